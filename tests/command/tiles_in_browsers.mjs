// Draws tiles in headless Chromium and says what is in the pictures and where rays meet the ground.
// Usage: node tiles_in_browsers.mjs FOLDER_OF_NODE_MODULES FOLDER_OF_PAGES JOBS.json; a line of JSON a picture.
import { createServer } from 'node:http';
import { createReadStream, readFileSync, statSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { extname, join, normalize } from 'node:path';

const [modules, pages, jobFile] = process.argv.slice(2);
const jobs = JSON.parse(readFileSync(jobFile));
const puppeteer = createRequire(modules + '/')('puppeteer-core');
const kinds = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.json': 'application/json', '.wasm': 'application/wasm' };

// Pages, modules and tiles from one origin.
const server = createServer((request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://local').pathname));
    const tiles = path.match(/^\/tiles\/(\d+)\/(.*)$/);
    const file = tiles ? join(jobs[tiles[1]].tiles, tiles[2]) : join(path.startsWith('/node_modules/') ? modules : pages, path);
    if (!statSync(file, { throwIfNoEntry: false })?.isFile()) { response.writeHead(404); response.end(); return; }
    response.writeHead(200, { 'content-type': kinds[extname(file)] ?? 'application/octet-stream' });
    createReadStream(file).pipe(response);
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
const origin = `http://127.0.0.1:${server.address().port}`;

const browser = await puppeteer.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--headless=new', '--no-sandbox', '--enable-unsafe-swiftshader', '--use-angle=swiftshader', '--disable-dev-shm-usage'],
    protocolTimeout: 300_000,
});

// Counts, against rays through the middles of pixels: what lies within the lowest surface must not be sky, what lies beyond the highest must be.
function judge(view, low, high, margin) {
    const source = window.viewer.canvas;
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [source.width, source.height];
    const context = canvas.getContext('2d');
    context.drawImage(source, 0, 0);
    const { data, width, height } = context.getImageData(0, 0, canvas.width, canvas.height);
    const sub = (a, b) => a.map((c, k) => c - b[k]);
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const unit = (a) => a.map((c) => c / Math.hypot(...a));
    const forward = unit(sub(view.target, view.eye));
    const right = unit(cross(forward, view.up));
    const up = cross(right, forward);
    const scale = Math.tan(view.degrees * Math.PI / 360) / (height / 2);
    const distance = Math.hypot(...view.eye);
    const found = { width, height, inside: 0, holes: 0, outside: 0, strays: 0, drawn: 0, at: [], centre: [0, 0], colours: [0, 0, 0] };
    for (let y = 0; y < height; y += 1) {
        for (let x = 0; x < width; x += 1) {
            const k = 4 * (y * width + x);
            const isSky = data[k] > 250 && data[k + 1] < 5 && data[k + 2] > 250;
            const [a, b] = [x + 0.5 - width / 2, height / 2 - y - 0.5].map((c) => c * scale);
            const ray = unit(forward.map((c, i) => c + right[i] * a + up[i] * b));
            const along = -dot(ray, view.eye);
            const passes = along > 0 ? Math.sqrt(Math.max(0, distance * distance - along * along)) : Infinity;
            // A pixel at the place where the ray passes the centre.
            const slack = margin * scale * Math.max(along, 0);
            if (passes < low - slack) { found.inside += 1; found.holes += isSky ? 1 : 0; if (isSky && found.at.length < 10) found.at.push([x, y, Math.round(passes)]); }
            if (passes > high + slack) { found.outside += 1; found.strays += isSky ? 0 : 1; }
            if (!isSky) {
                found.drawn += 1;
                found.centre[0] += x + 0.5; found.centre[1] += y + 0.5;
                for (const c of [0, 1, 2]) found.colours[c] += data[k + c];
            }
        }
    }
    for (const list of [found.centre, found.colours]) list.forEach((sum, k) => { list[k] = sum / Math.max(found.drawn, 1); });
    return { ...found, radius: Math.sqrt(found.drawn / Math.PI), picture: source.toDataURL('image/png') };
}

let status = 0;
try {
    for (const [number, job] of jobs.entries()) {
        const page = await browser.newPage();
        await page.setViewport({ width: job.size[0], height: job.size[1] });
        page.on('pageerror', (error) => console.error(`${job.client}: ${error}`));
        page.on('console', (message) => { if (message.type() === 'error') console.error(`${job.client}: ${message.text()}`); });
        await page.goto(`${origin}/${job.client}.html?tiles=/tiles/${number}/tileset.json&background=ff00ff&pixels=${job.pixels}`);
        await page.waitForFunction('window.viewer', { timeout: 120_000 });
        for (const view of job.views) {
            await page.evaluate((view) => window.viewer.look(view), view);
            await page.evaluate(() => window.viewer.settled());
            const { picture, ...found } = await page.evaluate(judge, view, job.low, job.high, 1.5);
            const picks = await page.evaluate((directions) => window.viewer.pick(directions), view.picks);
            const levels = await page.evaluate(() => window.viewer.levels());
            const tiles = {};
            for (const level of levels) tiles[level] = (tiles[level] ?? 0) + 1;
            writeFileSync(join(job.out, `${job.name}-${job.client}-${view.name}.png`), Buffer.from(picture.split(',')[1], 'base64'));
            console.log(JSON.stringify({ job: job.name, client: job.client, view: view.name, ...found, tiles, picks }));
        }
        await page.close();
    }
} catch (error) {
    console.error(error);
    status = 1;
}
await browser.close();
server.close();
process.exit(status);
