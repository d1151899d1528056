// node web/policy.mjs REPORT INDEX: enters the digest of the script of reports into the content security policy of index.html,
// so that this script runs in the frames of the site and no other does.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";

const [report, index] = process.argv.slice(2);
const scripts = [...readFileSync(report, "utf8").matchAll(/<script>(.*?)<\/script>/gs)].map(([, script]) => script);
if (scripts.length !== 1) throw new Error(`${report} has ${scripts.length} scripts, expected one`);
const source = `'sha256-${createHash("sha256").update(scripts[0]).digest("base64")}'`;
const page = readFileSync(index, "utf8");
if (!/'sha256-[^']*'/.test(page)) throw new Error(`${index} has no digest to replace`);
writeFileSync(index, page.replace(/'sha256-[^']*'/, source));
