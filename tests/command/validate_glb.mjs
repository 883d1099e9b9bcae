// Runs Khronos's validator over GLB files and prints each message. Usage: node validate_glb.mjs FOLDER_OF_NODE_MODULES FILE…
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';

const [modules, ...files] = process.argv.slice(2);
const validator = createRequire(modules + '/')('gltf-validator');
for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 0 });
    console.log(JSON.stringify({ file, messages: report.issues.messages, info: report.info }));
}
