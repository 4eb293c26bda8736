#!/usr/bin/env node
// Takes the pictures of docs/pictures from pages of examples, in Debian's Chromium, without a screen:
//     node scripts/report_pictures.mjs [TRUNNION] [FOLDER]
// TRUNNION: build/release/apps/trunnion/trunnion unless said; FOLDER: docs/pictures.
import { mkdirSync, mkdtempSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { missing, openBrowser, openPage, report, root } from '../tests/web/browser.mjs'

const trunnion = process.argv[2] ?? `${root}/build/release/apps/trunnion/trunnion`, output = process.argv[3] ?? `${root}/docs/pictures`
if (missing()) { console.error(missing()); process.exit(2) }
const example = name => `${root}/examples/${name}`
const pictures = [
  { name: 'report-blade', theme: 'light', words: [example('01_first_plan/blade.ngc'), '-m', 'xyzac-trt', '--setup', example('01_first_plan/setup.toml'), '--worth'],
    async act(page) { await page.locator('.drops tbody tr').first().click(); await page.keyboard.press('0'); await page.keyboard.press('r'); await page.evaluate(() => window.trunnion.state.set('height_mm', 10)) } },
  { name: 'report-dome', theme: 'dark', words: [example('06_report/dome.ngc'), '-m', 'xyzac-trt', '--setup', example('06_report/setup.toml'), '--worth'],
    async act(page) { await page.locator('[data-colouring="neighbour"]').click(); await page.evaluate(() => { const s = window.trunnion.state; s.moveTo(0.72 * s.end_s) }) } },
  { name: 'report-prediction', theme: 'light', words: [example('04_prediction/blend.cls'), '-m', 'ucp710', '--setup', example('04_prediction/blend_setup.toml'), '-c', 'lavernhe-2006', '--worth'],
    async act(page) { await page.locator('[data-colouring="cause"]').click(); await page.keyboard.press('m'); await page.evaluate(() => { const s = window.trunnion.state; s.moveTo(0.45 * s.run.end_s) }) } }
]

const folder = mkdtempSync(`${tmpdir()}/trunnion-pictures-`)
mkdirSync(output, { recursive: true })
const browser = await openBrowser()
try {
  for (const { name, theme, words, act } of pictures) {
    report(trunnion, [...words, '-q', '-o', `${folder}/${name}.html`])
    const { page, faults, close } = await openPage(browser, `${folder}/${name}.html`, { colorScheme: theme })
    await act(page)
    await page.evaluate(() => document.activeElement.blur())
    await page.mouse.move(1, 1)
    await page.waitForTimeout(700)
    await page.screenshot({ path: `${output}/${name}.png` })
    console.log(`${output}/${name}.png${faults.length ? `  console: ${faults.join('; ')}` : ''}`)
    await close()
  }
} finally {
  await browser.close()
  rmSync(folder, { recursive: true, force: true })
}
