// Keeps every file of the site from the first visit, so that it works without a network.
// `files.json` lists them: [{path, sha256}]. Each list has a cache of its own, and one that is complete replaces the others.

const LIST = "files.json";

async function digest(bytes) {
  const hash = await crypto.subtle.digest("SHA-256", bytes);
  return Array.from(new Uint8Array(hash), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Fetches a file anew and compares it with the list: of a site that is being published, old and new files must not mix. */
async function take(cache, { path, sha256 }) {
  const response = await fetch(path, { cache: "no-cache" });
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  const bytes = await response.clone().arrayBuffer();
  if ((await digest(bytes)) !== sha256) throw new Error(`${path} is not the file of ${LIST}`);
  await cache.put(path, response);
}

async function update() {
  const response = await fetch(LIST, { cache: "no-cache" });
  if (!response.ok) throw new Error(`${LIST}: ${response.status}`);
  const list = await response.clone().arrayBuffer();
  const name = `sagnac-${await digest(list)}`;
  const cache = await caches.open(name);
  // The list is kept last: a cache that has it is complete.
  if (await cache.match(LIST)) return;
  await Promise.all(JSON.parse(new TextDecoder().decode(list)).map((file) => take(cache, file)));
  await cache.put(LIST, response);
  const others = (await caches.keys()).filter((other) => other.startsWith("sagnac-") && other !== name);
  await Promise.all(others.map((other) => caches.delete(other)));
}

async function answer(request) {
  const wanted = request.mode === "navigate" ? "index.html" : request;
  return (await caches.match(wanted, { ignoreSearch: true })) ?? fetch(request);
}

addEventListener("install", (event) => event.waitUntil(update().then(() => skipWaiting())));
addEventListener("activate", (event) => event.waitUntil(clients.claim()));
addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.method !== "GET" || new URL(request.url).origin !== location.origin) return;
  event.respondWith(answer(request));
  // A new version is fetched while the page is shown, for the next visit.
  if (request.mode === "navigate") event.waitUntil(update().catch(() => {}));
});
