// The link: the part of the address behind `#` holds the mission, so that it needs no server.
const LONGEST = 30_000; // Characters; some programs cut longer addresses.
const MOST_BYTES = 1 << 20; // Bytes of files that are tried: more do not fit, however well they pack.
const KEYS = ["scenario", "map", "from", "to", "relays", "seed", "set", "packed"];

const toText = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""))
  .replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
const toBytes = (text) => Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));

const through = async (stream, bytes) =>
  new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

// What is plain to read stands in the link as it is; the rest of the recipe and the files are packed.
// Where that is too long for a link, there is `null`.
export async function write(recipe, dropped) {
  const given = recipe.map ? dropped : [];
  if (given.reduce((sum, { bytes }) => sum + bytes.length, 0) > MOST_BYTES) return null;
  const { set = [], pilot, loss, text, ...plain } = recipe;
  const parts = new URLSearchParams(Object.entries(plain).map(([key, value]) => [key, String(value)]));
  set.forEach((setting) => parts.append("set", setting));
  const files = given.map(({ path, bytes }) => [path, toText(bytes)]);
  if (pilot || loss || text || files.length) {
    const json = new TextEncoder().encode(JSON.stringify({ pilot, loss, text, files }));
    parts.set("packed", toText(await through(new CompressionStream("deflate-raw"), json)));
  }
  const link = `#${parts}`;
  return link.length <= LONGEST ? link : null;
}

function whole(key, text) {
  if (!/^\d{1,15}$/.test(text)) throw new Error(`the link has ${key}=${text}: give a whole number of at most 15 digits`);
  return Number(text);
}

async function unpack(text) {
  try {
    const json = await through(new DecompressionStream("deflate-raw"), toBytes(text));
    const { files = [], pilot, loss, text: scenario } = JSON.parse(new TextDecoder().decode(json));
    return { packed: { pilot, loss, text: scenario }, dropped: files.map(([path, text]) => ({ path, bytes: toBytes(text) })) };
  } catch {
    throw new Error("the link is damaged: copy the whole of it");
  }
}

// The recipe and the files of a link; an empty link is the demonstration.
export async function read(fragment) {
  const parts = new URLSearchParams(fragment.replace(/^#/, ""));
  const unknown = [...parts.keys()].find((key) => !KEYS.includes(key));
  if (unknown !== undefined) throw new Error(`the link has "${unknown}", which is none of ${KEYS.join(", ")}`);
  const recipe = {};
  for (const key of ["scenario", "map", "from", "to"]) if (parts.has(key)) recipe[key] = parts.get(key);
  for (const key of ["relays", "seed"]) if (parts.has(key)) recipe[key] = whole(key, parts.get(key));
  if (parts.has("set")) recipe.set = parts.getAll("set");
  if (!parts.has("packed")) return { recipe, dropped: [] };
  const { packed, dropped } = await unpack(parts.get("packed"));
  for (const [key, value] of Object.entries(packed)) if (value) recipe[key] = value;
  return { recipe, dropped };
}
