#!/usr/bin/env node
// Measures pages of `trunnion report`: how long one takes to write and how large it is, when its first picture stands, frames a second
// while it is turned, and the longest time for which it answers nobody. In Debian's Chromium, drawn by software, 1600 × 1000: as it does
// where there is no graphics card, which is the page by its own painter and only the tool path by SwiftShader; with --all-swiftshader
// the whole page goes through SwiftShader. Beside the time by the clock stands what the processors worked, which hardly depends on what
// else the machine does.
//     node scripts/measure_report.mjs [--all-swiftshader] TRUNNION PROGRAM [option of report …]
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync } from 'node:fs'
import { loadavg, tmpdir } from 'node:os'
import { pathToFileURL } from 'node:url'
import { missing, openBrowser, report } from '../tests/web/browser.mjs'

/** Processor time of all processes that this one started, and of theirs, s. */
function worked_s() {
  const processes = new Map()
  for (const id of readdirSync('/proc').filter(name => /^\d+$/.test(name))) {
    try {
      const text = readFileSync(`/proc/${id}/stat`, 'utf8'), fields = text.slice(text.lastIndexOf(')') + 2).split(' ')
      processes.set(Number(id), { parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12]) })
    } catch { /* it has ended */ }
  }
  const isOurs = id => { for (let at = processes.get(id)?.parent; at > 1; at = processes.get(at)?.parent) if (at === process.pid) return true; return false }
  let ticks = 0
  for (const [id, one] of processes) if (isOurs(id)) ticks += one.ticks
  return ticks / 100
}

const everything = process.argv[2] === '--all-swiftshader', [trunnion, ...words] = process.argv.slice(everything ? 3 : 2)
if (!words.length || missing()) { console.error(missing() || 'node scripts/measure_report.mjs TRUNNION PROGRAM [option …]'); process.exit(2) }
const folder = mkdtempSync(`${tmpdir()}/trunnion-measure-`), file = `${folder}/page.html`
const begin = performance.now()
report(trunnion, [...words, '-q', '-o', file])
console.log(`planned and written in ${((performance.now() - begin) / 1000).toFixed(2)} s, ${(statSync(file).size / 1e6).toFixed(2)} MB`)

console.log(`load ${loadavg().map(l => l.toFixed(1)).join(' ')}`)
const browser = await openBrowser(everything ? undefined : ['--disable-gpu'])
try {
  const context = await browser.newContext({ viewport: { width: 1600, height: 1000 }, offline: true }), page = await context.newPage()
  await page.addInitScript(() => {
    // The picture has been drawn, graphics and all, before the page says so; two frames later it is on the screen.
    new MutationObserver(() => {
      if (window.pictureAt || document.documentElement?.dataset.picture === undefined) return
      window.pictureAt = Infinity
      requestAnimationFrame(() => requestAnimationFrame(() => { window.pictureAt = performance.now() }))
    }).observe(document, { attributes: true, subtree: true })
    window.blocked = []
    new PerformanceObserver(list => { for (const task of list.getEntries()) window.blocked.push([Math.round(task.startTime), Math.round(task.duration)]) }).observe({ type: 'longtask', buffered: true })
  })
  const begun_s = worked_s()
  await page.goto(pathToFileURL(file).href, { waitUntil: 'commit' })
  await page.waitForSelector('html[data-ready]', { timeout: 120000, state: 'attached' })
  const ready_ms = await page.evaluate(() => new Promise(resolve => requestAnimationFrame(() => requestAnimationFrame(() => resolve(performance.now())))))
  const picture_ms = await page.evaluate(() => window.pictureAt)
  const opened = await page.evaluate(() => window.blocked)
  console.log(`first picture ${(picture_ms / 1000).toFixed(2)} s after opening, all there after ${(ready_ms / 1000).toFixed(2)} s, ${(worked_s() - begun_s).toFixed(2)} s of work; tasks above 50 ms (begin, length): ${opened.map(t => t.join('+')).join(' ') || 'none'}`)

  for (const ribbon of [false, true]) {
    await page.evaluate(ribbon => window.trunnion.state.set('ribbon', ribbon), ribbon)
    await page.waitForTimeout(1000)
    const before_s = worked_s()
    const turned = await page.evaluate(async () => {
      const { state, picture } = window.trunnion, frames = [], seconds = 3
      window.blocked.length = 0
      const begin = performance.now()
      for (let last = begin; last - begin < 1000 * seconds;) {
        const now = await new Promise(resolve => requestAnimationFrame(resolve))
        const angle = 0.02, { x, y } = picture.camera.position.clone().sub(picture.controls.target)
        picture.camera.position.x = picture.controls.target.x + x * Math.cos(angle) - y * Math.sin(angle)
        picture.camera.position.y = picture.controls.target.y + x * Math.sin(angle) + y * Math.cos(angle)
        picture.controls.update()
        frames.push(now - last)
        last = now
      }
      frames.sort((a, b) => a - b)
      return { rate: frames.length / seconds, frames: frames.length, slow: frames[Math.floor(0.95 * frames.length)], places: state.run.path.count, longest: Math.max(0, ...window.blocked.map(t => t[1])) }
    })
    console.log(`turning${ribbon ? ' with ribbon' : ''}: ${turned.rate.toFixed(1)} frames/s, ${(1000 * (worked_s() - before_s) / turned.frames).toFixed(0)} ms of work a frame, 95 % within ${turned.slow.toFixed(0)} ms, ${turned.places} places of the path, longest task ${turned.longest} ms`)
  }
  const zoomed = await page.evaluate(async () => {
    const { state } = window.trunnion
    state.set('ribbon', false)
    window.blocked.length = 0
    for (let k = 0; k < 20; ++k) {
      state.zoom(k < 10 ? 0.6 : 1.7)
      state.moveTo(state.end_s * (0.3 + 0.02 * k))
      await new Promise(resolve => setTimeout(resolve, 60))
    }
    return Math.max(0, ...window.blocked.map(t => t[1]))
  })
  console.log(`zooming and stepping: longest task ${zoomed} ms`)
} finally {
  await browser.close()
  rmSync(folder, { recursive: true, force: true })
}
