// Reads the block of numbers that the page carries; runtime/show/animation/page_data.py wrote it.

/** Bytes of gzip in base64, without their compression. */
export async function inflated(text) {
  const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The header, in which arrays are Float32Arrays: bytes of the same place lie together in a block. */
export async function readBlock(text) {
  const bytes = await inflated(text);
  const size = new DataView(bytes.buffer).getUint32(0, true);
  const { header, arrays: lengths } = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size)));
  const planes = bytes.subarray(4 + size);
  const count = planes.length / 4;
  const joined = new Uint8Array(planes.length);
  for (let k = 0; k < count; k += 1) {
    for (let place = 0; place < 4; place += 1) {
      joined[4 * k + place] = planes[place * count + k];
    }
  }
  const numbers = new Float32Array(joined.buffer);
  let first = 0;
  const arrays = lengths.map((length) => {
    first += length;
    return numbers.subarray(first - length, first);
  });
  return resolved(header, arrays);
}

/** A value with arrays in place of references to them. */
function resolved(value, arrays) {
  if (!value || typeof value !== "object") return value;
  if (Array.isArray(value)) return value.map((part) => resolved(part, arrays));
  if ("array" in value) return arrays[value.array];
  return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, resolved(part, arrays)]));
}
