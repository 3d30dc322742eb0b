// narx.onnx with onnxruntime-web, in a browser or Node. Reads rows "interval_s,sagittal,frontal,
// transverse" (s, rad/s; nan where lost) and writes the three angles (rad), their standard
// deviations (rad) and the quality. narx.json is what narx.export.read_identity returns.
// Any other row is an error.
import { readFileSync } from "node:fs";
import * as ort from "onnxruntime-web";

const [model, identity] = process.argv.slice(2);
if (!identity) {
    console.error("usage: node run.mjs narx.onnx narx.json < samples.csv > angles.csv");
    process.exit(2);
}
const about = JSON.parse(readFileSync(identity, "utf8"));
const [type, Numbers] =
    about.precision === "float" ? ["float32", Float32Array] : ["float64", Float64Array];
const tensor = (values, ...shape) => new ort.Tensor(type, Numbers.from(values), shape);

const session = await ort.InferenceSession.create(readFileSync(model));
let state = tensor(about.start_state, 1, about.start_state.length); // an unknown start pose
const lines = readFileSync(0, "utf8").split("\n");
if (lines.at(-1) === "") lines.pop();
const NO_NUMBER = /^\s*[+-]?(nan|inf(inity)?)\s*$/i; // a missing sample
const rows = lines.map((line, k) => {
    const fields = line.split(",");
    const row = fields.map((field) => (field.trim() ? Number(field) : NaN));
    const wrong = row.some((value, i) => Number.isNaN(value) && !NO_NUMBER.test(fields[i]));
    if (row.length !== 4 || wrong) {
        console.error(`line ${k + 1}: expected four numbers, separated by commas`);
        process.exit(1);
    }
    return row;
});
for (let first = 0; first < rows.length; first += 100) {
    const block = rows.slice(first, first + 100); // of any length: here a second
    const result = await session.run({
        axis_rates: tensor(block.flatMap((row) => row.slice(1)), 1, block.length, 3),
        interval_s: tensor(block.map((row) => row[0]), 1, block.length),
        state,
    });
    state = result.new_state;
    const [angles, std] = [result.angles.data, result.std_rad.data];
    block.forEach((_, k) => {
        const three = (values) => values.slice(3 * k, 3 * k + 3).join();
        console.log(`${three(angles)},${three(std)},${result.quality.data[k]}`);
    });
}
