// A study in the fragment of an address: deflated and in base64url, so that no server sees it.

/** Most bytes of the text of a study. */
const MOST_BYTES = 4 << 20;

/** Sends bytes through a stream; a short link may unpack to more than memory holds. */
async function through(bytes, stream) {
  const parts = [];
  let length = 0;
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    length += part.value.length;
    if (length > MOST_BYTES) throw new Error("the study is too long");
    parts.push(part.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

export async function pack(text) {
  const bytes = await through(text, new CompressionStream("deflate-raw"));
  const letters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** Most letters of a link, many times those of any study. */
const MOST_LETTERS = 200_000;

/** Throws where the text was cut off or is none of a link. */
export async function unpack(packed) {
  if (packed.length > MOST_LETTERS) throw new Error("the link is too long");
  const letters = atob(packed.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = await through(Uint8Array.from(letters, (letter) => letter.charCodeAt(0)), new DecompressionStream("deflate-raw"));
  return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
}
