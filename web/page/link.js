// The link: the part of the address behind `#` holds the mission, so that it needs no server.
const LONGEST = 30_000; // Characters; some programs cut longer addresses.

const toText = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""))
  .replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
const toBytes = (text) => Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));

const through = async (stream, bytes) =>
  new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

// What is plain to read stands in the link as it is; the rest of the recipe and the files are packed.
export async function write(recipe, dropped) {
  const { set = [], pilot, loss, text, ...plain } = recipe;
  const parts = new URLSearchParams(Object.entries(plain).map(([key, value]) => [key, String(value)]));
  set.forEach((setting) => parts.append("set", setting));
  const files = recipe.map ? dropped.map(({ path, bytes }) => [path, toText(bytes)]) : [];
  if (pilot || loss || text || files.length) {
    const json = new TextEncoder().encode(JSON.stringify({ pilot, loss, text, files }));
    parts.set("packed", toText(await through(new CompressionStream("deflate-raw"), json)));
  }
  const link = `#${parts}`;
  return link.length <= LONGEST ? link : null;
}

// The recipe and the files of a link; an empty link is the demonstration.
export async function read(fragment) {
  const parts = new URLSearchParams(fragment.replace(/^#/, ""));
  const recipe = {};
  for (const key of ["scenario", "map", "from", "to"]) if (parts.has(key)) recipe[key] = parts.get(key);
  for (const key of ["relays", "seed"]) if (parts.has(key)) recipe[key] = Number(parts.get(key));
  if (parts.has("set")) recipe.set = parts.getAll("set");
  let dropped = [];
  if (parts.has("packed")) {
    const json = await through(new DecompressionStream("deflate-raw"), toBytes(parts.get("packed")));
    const { files, ...rest } = JSON.parse(new TextDecoder().decode(json));
    dropped = files.map(([path, text]) => ({ path, bytes: toBytes(text) }));
    for (const key of ["pilot", "loss", "text"]) if (rest[key]) recipe[key] = rest[key];
  }
  return { recipe, dropped };
}
