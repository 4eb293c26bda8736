// The page's TypeScript keeps its types.
import { spawnSync } from 'node:child_process'
import { existsSync } from 'node:fs'
import { root } from './browser.mjs'

const compiler = `${root}/web/node_modules/typescript/bin/tsc`
if (!existsSync(compiler)) {
  console.log('skipped: TypeScript of web/package-lock.json is not installed')
  process.exit(77)
}
const done = spawnSync(process.execPath, [compiler, '-p', `${root}/web`], { encoding: 'utf8' })
process.stdout.write(done.stdout + done.stderr)
process.exit(done.status)
