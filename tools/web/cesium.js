// A planet's tiles in CesiumJS. Usage: cesium.html?tiles=URL of tileset.json, &background=rrggbb for another sky, &pixels=N for another error.
/* global Cesium */
const parameters = new URLSearchParams(location.search);
const url = parameters.get('tiles') ?? 'tiles/tileset.json';
const [radius] = (await (await fetch(url)).json()).extensions['3DTILES_ellipsoid'].radii;

// Before anything that asks for the Earth's.
const ellipsoid = new Cesium.Ellipsoid(radius, radius, radius);
Cesium.Ellipsoid.default = ellipsoid;
const widget = new Cesium.CesiumWidget('view', {
    globe: false, baseLayer: false, skyBox: false, skyAtmosphere: false, ellipsoid, scene3DOnly: true, msaaSamples: 1,
    contextOptions: { webgl: { preserveDrawingBuffer: true } },
});
const { scene, camera } = widget;
scene.backgroundColor = Cesium.Color.fromCssColorString(`#${parameters.get('background') ?? '000000'}`);
scene.postProcessStages.fxaa.enabled = false;
scene.screenSpaceCameraController.minimumZoomDistance = radius * 1e-6;
if (scene.sun) scene.sun.show = false;
if (scene.moon) scene.moon.show = false;

const tileset = await Cesium.Cesium3DTileset.fromUrl(url, {
    maximumScreenSpaceError: Number(parameters.get('pixels') ?? 16),
    // Both would draw the distance coarser than was asked for.
    dynamicScreenSpaceError: false, foveatedScreenSpaceError: false,
});
scene.primitives.add(tileset);
tileset.imageBasedLighting.imageBasedLightingFactor = new Cesium.Cartesian2(0.5, 0.0);
scene.light = new Cesium.DirectionalLight({ direction: new Cesium.Cartesian3(-1, 0, 0), intensity: 3 });

const vector = ([x, y, z]) => new Cesium.Cartesian3(x, y, z);
const unit = (v) => Cesium.Cartesian3.normalize(v, new Cesium.Cartesian3());

// Light from beside the camera, for ever.
scene.preRender.addEventListener(() => {
    const aside = Cesium.Cartesian3.multiplyByScalar(camera.rightWC, 0.7, new Cesium.Cartesian3());
    Cesium.Cartesian3.add(aside, camera.directionWC, aside);
    scene.light.direction = unit(aside);
});

function look({ eye, target, up, degrees }) {
    if (degrees) {
        // Cesium's angle is that of the longer side, the one asked for that of the height.
        const wider = Math.max(1, scene.canvas.clientWidth / scene.canvas.clientHeight);
        camera.frustum.fov = 2 * Math.atan(Math.tan(Cesium.Math.toRadians(degrees) / 2) * wider);
    }
    camera.frustum.near = 1;
    const direction = unit(Cesium.Cartesian3.subtract(vector(target), vector(eye), new Cesium.Cartesian3()));
    const right = unit(Cesium.Cartesian3.cross(direction, vector(up), new Cesium.Cartesian3()));
    camera.setView({
        destination: vector(eye),
        orientation: { direction, up: Cesium.Cartesian3.cross(right, direction, new Cesium.Cartesian3()) },
    });
}

function settled() {
    return new Promise((resolve) => {
        let still = 0;
        const stop = scene.postRender.addEventListener(() => {
            still = tileset.tilesLoaded && tileset.statistics.numberOfPendingRequests === 0 ? still + 1 : 0;
            if (still > 5) { stop(); resolve(); }
        });
    });
}

// Where rays down to the planet's centre meet what is drawn: distance from the centre, and the tile.
function pick(directions) {
    return directions.map((direction) => {
        const origin = Cesium.Cartesian3.multiplyByScalar(vector(direction), 2 * radius, new Cesium.Cartesian3());
        const ray = new Cesium.Ray(origin, Cesium.Cartesian3.negate(vector(direction), new Cesium.Cartesian3()));
        let nearest = null;
        for (const tile of tileset._selectedTiles) {
            const sphere = tile.boundingSphere;
            if (!Cesium.IntersectionTests.raySphere(ray, sphere)) continue;
            const hit = tile.content.pick(ray, scene.frameState, new Cesium.Cartesian3());
            if (!hit) continue;
            const distance = Cesium.Cartesian3.magnitude(hit);
            if (!nearest || distance > nearest.radius) nearest = { radius: distance, error: tile.extras.error_m, patch: tile.extras.patch };
        }
        return nearest;
    });
}

look({ eye: [3 * radius, 0, 0], target: [0, 0, 0], up: [0, 0, 1] });
window.viewer = {
    look, settled, pick, canvas: scene.canvas,
    levels: () => tileset._selectedTiles.map((tile) => Number(tile.extras.patch.split('/')[1])),
};
