// Files that the user drops or chooses: which of them is the scenario or the map.
const LARGEST = 64 << 20; // Bytes of all files together.

// The endings of files that a map begins with, the likeliest first.
const ENTRIES = ["toml", "yaml", "yml", "dot", "sdf", "mak", "wpj", "thconfig", "svx", "3d", "th", "srv", "tro", "dat", "txt"];
const endingOf = (path) => path.toLowerCase().split("/").pop().split(".").pop();

async function walk(entry, into) {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    into.push({ path: entry.fullPath.replace(/^\//, ""), file });
    return;
  }
  const reader = entry.createReader();
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return;
    for (const each of some) await walk(each, into);
  }
}

export async function ofDrop(transfer) {
  // The list is empty after the first wait.
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  const found = [];
  for (const entry of entries) await walk(entry, found);
  return contents(found);
}

export const ofInput = (list) =>
  contents([...list].map((file) => ({ path: file.webkitRelativePath || file.name, file })));

async function contents(found) {
  const bytes = found.reduce((sum, { file }) => sum + file.size, 0);
  if (bytes > LARGEST) throw new Error(`these files have ${bytes >> 20} MiB; give at most ${LARGEST >> 20}`);
  const read = async ({ path, file }) => ({ path, bytes: new Uint8Array(await file.arrayBuffer()) });
  return Promise.all(found.map(read));
}

// The files that a mission may begin with, the likeliest first: of one kind, the one that names the most
// others comes first, and then the one in the outermost folder.
export function entries(files) {
  const kinds = files.filter(({ path }) => ENTRIES.includes(endingOf(path)));
  const text = ({ bytes }) => new TextDecoder().decode(bytes.subarray(0, 100_000));
  const includes = (file) => (text(file).match(/^\s*(\*include|input|source)\b/gim) ?? []).length;
  const rank = (file) => [ENTRIES.indexOf(endingOf(file.path)), -includes(file), file.path.split("/").length];
  const ranked = kinds.map((file) => ({ file, rank: rank(file) }));
  const before = (a, b) => a.rank.map((value, n) => value - b.rank[n]).find((value) => value !== 0) ?? 0;
  return ranked.sort(before).map(({ file }) => file.path);
}

export const isScenario = (path) => endingOf(path) === "toml";
