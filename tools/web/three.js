// A planet's tiles in three.js by 3DTilesRendererJS. Usage: three.html?tiles=URL of tileset.json, &background=rrggbb for another sky,
// &pixels=N for another error.
import * as THREE from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { GlobeControls, TilesRenderer } from '3d-tiles-renderer/three';

const parameters = new URLSearchParams(location.search);
const url = parameters.get('tiles') ?? 'tiles/tileset.json';
const [radius] = (await (await fetch(url)).json()).extensions['3DTILES_ellipsoid'].radii;

// Logarithmic, since one picture reaches from metres to a planet's radius.
const renderer = new THREE.WebGLRenderer({ antialias: false, logarithmicDepthBuffer: true, preserveDrawingBuffer: true });
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(`#${parameters.get('background') ?? '000000'}`);
const camera = new THREE.PerspectiveCamera(60, 1, 1, 20 * radius);
const sun = new THREE.DirectionalLight(0xffffff, 3);
scene.add(sun, sun.target, new THREE.AmbientLight(0xffffff, 0.4));

const tiles = new TilesRenderer(url);
const loader = new GLTFLoader(tiles.manager);
loader.setMeshoptDecoder(MeshoptDecoder);
tiles.manager.addHandler(/\.glb$/, loader);
tiles.errorTarget = Number(parameters.get('pixels') ?? 16);
tiles.setCamera(camera);
scene.add(tiles.group);
const controls = new GlobeControls(scene, camera, renderer.domElement);
controls.setEllipsoid(tiles.ellipsoid, tiles.group);
tiles.addEventListener('load-root-tileset', () => controls.setEllipsoid(tiles.ellipsoid, tiles.group));

const vector = ([x, y, z]) => new THREE.Vector3(x, y, z);

function resize() {
    renderer.setSize(innerWidth, innerHeight);
    camera.aspect = innerWidth / innerHeight;
    camera.updateProjectionMatrix();
    tiles.setResolutionFromRenderer(camera, renderer);
}
addEventListener('resize', resize);
resize();

function look({ eye, target, up, degrees }) {
    controls.enabled = false;
    if (degrees) camera.fov = degrees;
    camera.up.copy(vector(up));
    camera.position.copy(vector(eye));
    camera.lookAt(vector(target));
    // The controls set others.
    [camera.near, camera.far] = [1, 20 * radius];
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
}

let frames = 0;
renderer.setAnimationLoop(() => {
    if (controls.enabled) controls.update();
    camera.updateMatrixWorld();
    // Light from beside the camera.
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    sun.position.copy(camera.getWorldDirection(new THREE.Vector3()).addScaledVector(right, 0.7).multiplyScalar(-radius));
    tiles.update();
    renderer.render(scene, camera);
    frames += 1;
});

async function settled() {
    let still = 0;
    while (still < 12) {
        const before = frames;
        while (frames === before) await new Promise((resolve) => setTimeout(resolve, 20));
        const { queued, downloading, parsing } = tiles.stats;
        const isBusy = tiles.isLoading || queued + downloading + parsing > 0 || tiles.visibleTiles.size === 0;
        still = isBusy ? 0 : still + 1;
    }
}

// Where rays down to the planet's centre meet what is drawn: distance from the centre, and the tile.
function pick(directions) {
    return directions.map((direction) => {
        const caster = new THREE.Raycaster(vector(direction).multiplyScalar(2 * radius), vector(direction).negate());
        let nearest = null;
        for (const tile of tiles.visibleTiles) {
            for (const hit of caster.intersectObject(tile.engineData.scene, true)) {
                const distance = hit.point.length();
                if (!nearest || distance > nearest.radius) nearest = { radius: distance, error: tile.extras.error_m, patch: tile.extras.patch };
            }
        }
        return nearest;
    });
}

camera.position.set(3 * radius, 0, 0);
camera.up.set(0, 0, 1);
camera.lookAt(0, 0, 0);
window.viewer = {
    look, settled, pick, canvas: renderer.domElement,
    levels: () => [...tiles.visibleTiles].map((tile) => Number(tile.extras.patch.split('/')[1])),
};
