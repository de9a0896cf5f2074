// SPDX-License-Identifier: Apache-2.0
// node build.mjs [--outdir DIR] [--tests] [--proto FILE] [--shaders DIR]
//   --outdir   writes the files of the page to DIR
//   --tests    writes the unit tests to generated/tests.mjs, for `node --test`
//   --shaders  where the renderer's shaders are
// Generates the messages from the schema and type-checks everything first.
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { build } from "esbuild";

const home = dirname(fileURLToPath(import.meta.url));
const { values } = parseArgs({
  options: {
    outdir: { type: "string" },
    proto: { type: "string", default: join(home, "../../proto/fanlight.proto") },
    shaders: { type: "string", default: join(home, "../../shaders") },
    tests: { type: "boolean", default: false },
  },
});
if (!values.outdir && !values.tests) {
  console.error("build.mjs: expected --outdir DIR, --tests, or both");
  process.exit(2);
}

const run = (command, ...args) => {
  try {
    execFileSync(command, args, { cwd: home, stdio: "inherit" });
  } catch (failure) {
    console.error(`build.mjs: ${command} ${args.join(" ")}: ${failure.message}`);
    process.exit(1);
  }
};

/** The text of a shader with each file that it includes, once. */
function shaderText(path, included = new Set()) {
  included.add(path);
  const lines = readFileSync(path, "utf8").split("\n");
  return lines
    .map((line) => {
      const name = /^#include "(.*)"/.exec(line)?.[1];
      if (name) return included.has(join(shaders, name)) ? "" : shaderText(join(shaders, name), included);
      // GLSL ES has no attributes.
      return line
        .replace(/\/\/.*/, "")
        .replace(/\[\[\w+\]\] */g, "")
        .trim();
    })
    .filter((line) => line)
    .join("\n");
}

const shaders = resolve(values.shaders);
const shaderTexts = {
  name: "shaders",
  setup({ onResolve, onLoad }) {
    onResolve({ filter: /\.(frag|vert)$/ }, ({ path }) => ({ path: join(shaders, "web", path), namespace: "shader" }));
    onLoad({ filter: /.*/, namespace: "shader" }, ({ path }) => ({ contents: shaderText(path), loader: "text" }));
  },
};

// Modules that the page imports when they are first needed.
const loadedLater = ["./clip.js", "./archive_form.js", "./transfer_editor.js"];

const proto = resolve(values.proto);
mkdirSync(join(home, "generated"), { recursive: true });
run(
  "protoc",
  `--plugin=${join(home, "node_modules/.bin/protoc-gen-es")}`,
  "--es_out=generated",
  "--es_opt=target=js+dts",
  `-I${dirname(proto)}`,
  proto,
);
run(process.execPath, join(home, "node_modules/typescript/bin/tsc"), "--project", home);

if (values.tests) {
  const tests = readdirSync(join(home, "test"))
    .map((name) => `import "./${name}";`)
    .join("\n");
  await build({
    stdin: { contents: tests, resolveDir: join(home, "test") },
    outfile: join(home, "generated/tests.mjs"),
    plugins: [shaderTexts],
    external: loadedLater,
    bundle: true,
    platform: "node",
    format: "esm",
    target: "node18",
    logLevel: "warning",
  });
}

if (values.outdir) {
  // Which files of which packages are in the page, for its bill of materials.
  const bundled = {};
  const bundle = async (options) => {
    const always = { absWorkingDir: home, bundle: true, minify: true, metafile: true, logLevel: "warning" };
    const built = await build({ ...options, ...always });
    Object.assign(bundled, built.metafile.outputs);
    return built;
  };
  await bundle({
    entryPoints: { viewer: join(home, "src/main.ts") },
    plugins: [shaderTexts],
    outdir: resolve(values.outdir),
    format: "iife",
    external: loadedLater,
    target: ["chrome100", "firefox100", "safari15.4"],
  });
  await bundle({
    entryPoints: loadedLater.map((name) => join(home, "src", name.replace(/js$/, "ts"))),
    outdir: resolve(values.outdir),
    format: "esm",
    target: ["chrome100", "firefox100", "safari15.4"],
  });
  await bundle({
    entryPoints: { viewer: join(home, "page/viewer.css") },
    outdir: resolve(values.outdir),
    target: ["chrome105", "firefox110", "safari16"],
  });
  // For pages of other sites: the class and its style in one module.
  await bundle({
    entryPoints: { "fanlight-view": join(home, "src/embed/fanlight_view.ts") },
    outdir: resolve(values.outdir),
    loader: { ".css": "text" },
    format: "esm",
    target: ["chrome100", "firefox101", "safari16.4"],
  });
  const share = await bundle({
    entryPoints: [join(home, "src/share/main.ts")],
    plugins: [shaderTexts],
    write: false,
    format: "iife",
    target: ["chrome100", "firefox100", "safari15.4"],
  });
  // One file that opens without a server: the script stands in it.
  const script = share.outputFiles[0].text.replaceAll("</script", "<\\/script");
  const template = readFileSync(join(home, "page/share.html"), "utf8");
  writeFileSync(
    join(resolve(values.outdir), "share.html"),
    template.replace("/*script*/", () => script),
  );
  for (const name of ["index.html", "favicon.svg"]) {
    copyFileSync(join(home, "page", name), join(resolve(values.outdir), name));
  }
  writeFileSync(join(home, "generated/bundled.json"), JSON.stringify(bundled));
}
