// The shipped studies, and the files that studies name.

/** The shipped studies: `{name, title, question, kind, picture, text, files}`, where `picture` is the address of a picture. */
export const gallery = fetch("gallery.json").then((response) => response.json());

const shippedFiles = gallery.then((studies) => Object.assign({}, ...studies.map(({ files }) => files)), () => ({}));

/** A study as the program takes it, with those files of shipped studies that it names. */
export async function studyOf(text, name) {
  const named = Object.entries(await shippedFiles).filter(([file]) => text.includes(`"${file}"`));
  return { text, name: `${name}.toml`, files: Object.fromEntries(named) };
}
