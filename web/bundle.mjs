// Bundles the page into a C++ source file: node bundle.mjs OUTPUT.cpp
// Script and style become string literals, and the page's policy allows just these two by their hashes.
import { createHash } from 'node:crypto'
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs'
import { dirname } from 'node:path'
import { fileURLToPath } from 'node:url'
import { build } from 'esbuild'

const here = dirname(fileURLToPath(import.meta.url))

// Charts are drawn anew at every step of the zoom, some thousand short strokes each: by the processor in milliseconds, by graphics
// that are themselves the processor's work in seconds. uPlot asks for its canvas without a word of this.
const chartsOnProcessor = { name: 'charts-on-processor', setup: of => of.onLoad({ filter: /uPlot\.esm\.js$/ }, ({ path }) => {
  const asked = 'can.getContext("2d")', parts = readFileSync(path, 'utf8').split(asked)
  if (parts.length !== 2) throw new Error(`uPlot does not ask once for ${asked}`)
  return { contents: parts.join('can.getContext("2d", { willReadFrequently: true })'), loader: 'js' }
}) }

async function bundled(entry, options) {
  const result = await build({ entryPoints: [`${here}/src/${entry}`], absWorkingDir: here, bundle: true, minify: true, write: false,
    logLevel: 'warning', charset: 'ascii', target: 'es2022', legalComments: 'none', plugins: [chartsOnProcessor], ...options })
  return result.outputFiles[0].text.trim()
}

// The literal is put together from pieces: not every compiler takes one of any length.
function literal(name, text) {
  const delimiter = 'trunnion', piece = 60000, pieces = []
  if (text.includes(`)${delimiter}"`)) throw new Error('the delimiter of the raw string occurs in the bundle')
  for (let at = 0; at < text.length; at += piece) pieces.push(`R"${delimiter}(${text.slice(at, at + piece)})${delimiter}"`)
  return `constexpr char ${name}[] =\n${pieces.join('\n')};`
}

const hash = text => `'sha256-${createHash('sha256').update(text).digest('base64')}'`

const style = await bundled('page.css', { loader: { '.css': 'css' } })
const licence = name => readFileSync(`${here}/node_modules/${name}/LICENSE`, 'utf8').replaceAll('*/', '* /').trim()
const script = `${await bundled('main.ts', { format: 'iife' })}
/* three.js:\n${licence('three')}\n\nuPlot:\n${licence('uplot')}\n*/`
if (/<\/(script|style)/i.test(script + style)) throw new Error('the bundle would end its element')
const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; img-src data: blob:`

const output = process.argv[2]
mkdirSync(dirname(output), { recursive: true })
writeFileSync(output, `// Made by web/bundle.mjs.
#include "detail/web_page.hpp"

// NOLINTBEGIN: nobody reads it
namespace trunnion::report::detail {

namespace {

${literal('style', style)}
${literal('script', script)}
${literal('policy', policy)}

}  // namespace

const WebPage& web_page() {
    static const WebPage page{.style = {style, sizeof style - 1},
                              .script = {script, sizeof script - 1},
                              .policy = {policy, sizeof policy - 1},
                              .missing = {}};
    return page;
}

}  // namespace trunnion::report::detail
// NOLINTEND
`)
