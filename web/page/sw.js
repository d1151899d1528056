// Keeps every file of the site from the first visit, so that it works without a network. A new version of the site has a new version of
// this file: the browser installs it beside the old one, which goes on serving the pages that are open, and takes it when they are closed.

/** The digest of `files.json`, which `web/build` enters: of [{path, sha256}], all files but this one. */
const VERSION = "development";
const CACHE = `sagnac-${VERSION}`;
const LIST = "files.json";

async function digest(bytes) {
  const hash = await crypto.subtle.digest("SHA-256", bytes);
  return Array.from(new Uint8Array(hash), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Fetches a file anew and compares it with its digest: of a site that is being published, old and new files must not mix. */
async function take(cache, path, sha256) {
  const response = await fetch(path, { cache: "no-cache" });
  if (!response.ok) throw new Error(`${path}: ${response.status}`);
  const bytes = await response.clone().arrayBuffer();
  if ((await digest(bytes)) !== sha256) throw new Error(`${path} is of another version`);
  await cache.put(path, response);
  return bytes;
}

async function install() {
  const cache = await caches.open(CACHE);
  const list = await take(cache, LIST, VERSION);
  await Promise.all(JSON.parse(new TextDecoder().decode(list)).map(({ path, sha256 }) => take(cache, path, sha256)));
}

async function removeOthers() {
  const others = (await caches.keys()).filter((name) => name.startsWith("sagnac-") && name !== CACHE);
  await Promise.all(others.map((name) => caches.delete(name)));
}

async function answer(request) {
  const cache = await caches.open(CACHE);
  const wanted = request.mode === "navigate" ? "index.html" : request;
  return (await cache.match(wanted, { ignoreSearch: true })) ?? fetch(request);
}

addEventListener("install", (event) => event.waitUntil(install()));
addEventListener("activate", (event) => event.waitUntil(removeOthers().then(() => clients.claim())));
addEventListener("fetch", (event) => {
  const { request } = event;
  if (request.method !== "GET" || new URL(request.url).origin !== location.origin) return;
  event.respondWith(answer(request));
});
