// Pages of `trunnion report` in Debian's Chromium, without a screen, drawn by software.
import { spawnSync } from 'node:child_process'
import { existsSync } from 'node:fs'
import { createRequire } from 'node:module'
import { fileURLToPath, pathToFileURL } from 'node:url'

export const root = fileURLToPath(new URL('../..', import.meta.url)).replace(/\/$/, '')
export const chromium_path = process.env.TRUNNION_CHROMIUM ?? '/usr/bin/chromium'

/** Why there can be no browser; empty: there can. */
export function missing() {
  if (!existsSync(chromium_path)) return `no browser at ${chromium_path}`
  if (!existsSync(`${root}/web/node_modules/playwright-core`)) return 'playwright-core of web/package-lock.json is not installed'
  return ''
}

/** What draws: by default all of the page goes through SwiftShader. */
export async function openBrowser(graphics = ['--use-gl=angle', '--use-angle=swiftshader']) {
  const { chromium } = createRequire(`${root}/web/package.json`)('playwright-core')
  return chromium.launch({ executablePath: chromium_path, headless: true,
    args: ['--no-sandbox', ...graphics, '--enable-unsafe-swiftshader', '--disable-dev-shm-usage', '--font-render-hinting=none'] })
}

/** Ends with the exit status where it is not among those wanted. */
export function report(trunnion, words, statuses = [0, 1]) {
  const done = spawnSync(trunnion, ['report', ...words], { encoding: 'utf8' })
  if (!statuses.includes(done.status)) throw new Error(`trunnion report ${words.join(' ')} ends with ${done.status}\n${done.stdout}${done.stderr}`)
  return done
}

/** Opens a page from its file and waits until it stands; `faults`: what the console says. */
export async function openPage(browser, file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1600, height: 1000 }, colorScheme: 'light', offline: true, ...options })
  const page = await context.newPage(), faults = []
  page.on('console', message => { if (['error', 'warning'].includes(message.type()) && !/GPU stall|swiftshader|GL Driver Message/i.test(message.text())) faults.push(message.text()) })
  page.on('pageerror', error => faults.push(String(error)))
  page.on('request', request => { if (!/^(file|data|blob):/.test(request.url())) faults.push(`asks for ${request.url()}`) })
  await page.goto(pathToFileURL(file).href)
  await page.waitForSelector('html[data-ready]', { timeout: 60000, state: 'attached' }).catch(error => { throw new Error(`${error.message}\n${faults.join('\n')}`) })
  return { page, faults, close: () => context.close() }
}
