// The page in a browser: page_test.mjs TRUNNION. It opens from its file without a word on the console, and what it shows is what the
// summary says.
import assert from 'node:assert/strict'
import { spawnSync } from 'node:child_process'
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { missing, openBrowser, openPage, report, root } from './browser.mjs'

const trunnion = process.argv[2], folder = mkdtempSync(`${tmpdir()}/trunnion-web-`)
const leave = status => { rmSync(folder, { recursive: true, force: true }); process.exit(status) }
if (missing()) { console.log(`skipped: ${missing()}`); leave(77) }

const blade = `${root}/examples/01_first_plan/blade.ngc`
const job = ['-m', 'xyzac-trt', '--setup', `${root}/examples/01_first_plan/setup.toml`, '-q']
const first = spawnSync(trunnion, ['report', blade, ...job, '-o', `${folder}/blade.html`], { encoding: 'utf8' })
if (first.stderr.includes('REP0001')) { console.log(`skipped: ${first.stderr.trim()}`); leave(77) }
assert.equal(first.status, 0, first.stderr)
spawnSync(trunnion, ['plan', blade, ...job, '--summary', `${folder}/summary.json`])
const summary = JSON.parse(readFileSync(`${folder}/summary.json`, 'utf8'))

/** Axis positions through the drawn machine's own kinematics against the tip that the program recorded, mm. */
const apartFromMachine = page => page.evaluate(() => {
  const { state, picture } = window.trunnion
  let worst = 0
  for (let k = 0; k <= 200; ++k) {
    const time_s = state.run.end_s * k / 200, positions = {}
    for (const a of state.content.machine.axes) positions[a.letter] = state.run.valueAt(state.run.axis(a.letter, 'position'), time_s)
    const pose = picture.machine.pose(positions), tool = state.run.toolAt(time_s)
    const gauge = picture.tool.group.position.clone().set(0, 0, -tool.length_mm)
    const tip = gauge.applyMatrix4(pose.links.at(-1)).applyMatrix4(pose.part.clone().invert()), want = state.run.poseAt(time_s).tip
    worst = Math.max(worst, Math.hypot(tip.x - want[0], tip.y - want[1], tip.z - want[2]))
  }
  return worst
})

const tests = {
  async 'shows what the summary says'(page) {
    const shown = name => page.locator(`.summary [data-value="${name}"]`).innerText()
    assert.equal(await shown('cycle_time_s'), `${summary.cycle_time_s.toFixed(3)} s`)
    assert.equal(await shown('cutting_time_s'), `${summary.cut_time_s.toFixed(3)} s`)
    assert.equal(await shown('rapid_time_s'), `${summary.rapid_time_s.toFixed(3)} s`)
    for (const [letter, load] of Object.entries(summary.axes))
      assert.equal(await shown(`limiting_share_${letter}`), `${(100 * load.limiting_share).toFixed(1)} %`)
    const rows = await page.locator('.drops tbody tr').allInnerTexts(), drops = [...summary.feed_drops].sort((a, b) => b.lost_s - a.lost_s)
    assert.equal(rows.length, drops.length)
    drops.forEach((d, k) => assert.ok(rows[k].startsWith(`${d.line}\t`) && rows[k].includes(d.cause) && rows[k].endsWith(`${d.lost_s.toFixed(3)} s`), rows[k]))
    assert.match(await page.locator('.command code').innerText(), /^trunnion report .*blade\.ngc -m xyzac-trt/)
  },
  async 'a feed drop leads to its block'(page) {
    const drop = [...summary.feed_drops].sort((a, b) => b.lost_s - a.lost_s)[1]
    await page.locator('.drops tbody tr').nth(1).click()
    const way = await page.evaluate(() => { const s = window.trunnion.state; return s.run.wayAt(s.get('cursor_s')) })
    assert.ok(way >= drop.s_from_mm - 0.5 && way <= drop.s_to_mm + 0.5, `${way} mm`)
    await page.waitForFunction(() => {  // both are drawn in the frames that follow
      const told = document.querySelector('.told [data-value="line"]'), current = document.querySelector('.line.current')
      return told && current && told.innerText === current.dataset.line
    })
    const current = page.locator('.line.current')
    const line = Number(await current.getAttribute('data-line'))
    assert.equal(await current.locator('code').innerText(), readFileSync(blade, 'utf8').split('\n')[line - 1])
  },
  async 'every colouring paints the path its way'(page) {
    const seen = new Set()
    for (const name of ['feed', 'cause', 'deviation', 'contact', 'turn', 'neighbour']) {
      await page.locator(`[data-colouring="${name}"]`).click()
      assert.equal(await page.locator(`[data-colouring="${name}"]`).getAttribute('aria-pressed'), 'true')
      seen.add(await page.locator('.legend strong').innerText())
      const kinds = await page.evaluate(() => {
        const { picture } = window.trunnion, colours = new Set()
        const all = [...picture.drawn.values()][0].path.colours.array
        for (let i = 0; i < all.length; i += 4) colours.add(`${all[i]},${all[i + 1]},${all[i + 2]}`)
        return colours.size
      })
      assert.ok(kinds >= (name === 'cause' ? 3 : 10), `${name} has ${kinds} colours`)
    }
    assert.equal(seen.size, 6)
  },
  async 'the drawn tool is where the machine puts it'(page) {
    const worst = await apartFromMachine(page)
    assert.ok(worst < 0.05, `${worst} mm apart`)
  },
  async 'keys and frames'(page) {
    await page.keyboard.press('2')
    assert.equal(await page.locator('[data-colouring="cause"]').getAttribute('aria-pressed'), 'true')
    await page.keyboard.press('m')
    assert.equal(await page.locator('[data-frame="machine"]').getAttribute('aria-pressed'), 'true')
    await page.keyboard.press('t')
    assert.equal(await page.locator('html').getAttribute('data-theme'), 'dark')
    await page.keyboard.press('0')
    const before = Number(await page.evaluate(() => window.trunnion.state.get('cursor_s')))
    await page.keyboard.press('ArrowLeft')
    const left = await page.evaluate(() => window.trunnion.state.get('cursor_s'))
    assert.ok(left < before)
    await page.keyboard.press('[')
    assert.ok(await page.evaluate(() => window.trunnion.state.get('cursor_s')) < left)
    await page.keyboard.press(']')
    assert.equal(await page.evaluate(() => window.trunnion.state.get('cursor_s')), before)
    await page.keyboard.press('?')
    assert.ok(await page.locator('dialog[open]').isVisible())
    await page.keyboard.press('Escape')
    await page.keyboard.press('m')
    await page.keyboard.press('t')
  },
  async 'pointing at the path tells line, text, feeds and cause'(page) {
    await page.keyboard.press('0')
    await page.evaluate(() => window.trunnion.picture.fit())
    const box = await page.locator('.picture canvas').boundingBox()
    const at = await page.evaluate(() => {
      const { picture, state } = window.trunnion, path = state.run.path, k = path.line.indexOf(40)
      picture.camera.updateMatrixWorld()
      const point = picture.camera.position.clone().fromArray(path.tip, 3 * k).project(picture.camera)
      return [(point.x + 1) / 2, (1 - point.y) / 2]
    })
    await page.mouse.move(box.x + box.width * at[0], box.y + box.height * at[1])
    await page.locator('.hover').waitFor({ timeout: 10000 })
    const told = await page.locator('.hover').innerText()
    const found = /^line (\d+)\s+(.*)\n/.exec(told)
    assert.ok(found, told || 'nothing is told')
    assert.equal(found[2].trim(), readFileSync(blade, 'utf8').split('\n')[Number(found[1]) - 1].trim())
    assert.match(told, /feed.* of .*mm\/min/)
    assert.match(told, /limited by/)
  },
  async 'dragging in a chart zooms all of them'(page) {
    await page.keyboard.press('0')
    const over = await page.locator('.u-over').first().boundingBox(), end_s = await page.evaluate(() => window.trunnion.state.end_s)
    await page.mouse.move(over.x + over.width * 0.25, over.y + over.height / 2)
    await page.mouse.down()
    await page.mouse.move(over.x + over.width * 0.5, over.y + over.height / 2, { steps: 4 })
    await page.mouse.up()
    const [from, to] = await page.evaluate(() => window.trunnion.state.get('window'))
    assert.ok(Math.abs(from / end_s - 0.25) < 0.02 && Math.abs(to / end_s - 0.5) < 0.02, `${from} … ${to} of ${end_s}`)
    await page.keyboard.press('0')
  },
  async 'lines of the program choose what is shown'(page) {
    await page.locator('[aria-label="Shown from line"]').fill('70')
    await page.locator('[aria-label="Shown to line"]').fill('80')
    await page.locator('[aria-label="Shown to line"]').press('Enter')
    const lines = await page.evaluate(() => { const s = window.trunnion.state; return s.get('window').map(t => s.run.lineAt(t)) })
    assert.ok(lines[0] >= 69 && lines[0] <= 70 && lines[1] >= 80 && lines[1] <= 81, lines.join(' … '))
    await page.keyboard.press('Tab')
    await page.evaluate(() => { document.activeElement.blur(); window.trunnion.state.show(0, window.trunnion.state.end_s) })
  },
  async 'on paper there is the summary'(page) {
    await page.emulateMedia({ media: 'print' })
    assert.ok(await page.locator('.summary').isVisible())
    assert.ok(!(await page.locator('.charts').isVisible()))
    await page.emulateMedia({ media: 'screen' })
  }
}

async function others(browser) {
  const evil = `${folder}/<img src=x onerror=alert(1)>.ngc`
  writeFileSync(evil, `;<script>document.title='broken'</script>\n;</script><script>alert(2)</script>\nG21 G90 G94\nG1 X0 Y0 Z0 A0 C0 F600\nG1 X20 (<b>bold</b>)\nG1 Y20\n`)
  report(trunnion, [evil, '-m', 'xyzac-trt', '-q', '-o', `${folder}/evil.html`])
  const marked = await openPage(browser, `${folder}/evil.html`)
  marked.page.on('dialog', () => { marked.faults.push('a dialog') })
  assert.equal(await marked.page.locator('.line code').first().innerText(), ";<script>document.title='broken'</script>")
  assert.equal(await marked.page.locator('h1').innerText().then(t => t.includes('<img src=x onerror=alert(1)>')), true)
  assert.equal(await marked.page.locator('.program b, .page img[src="x"]').count(), 0)
  assert.ok((await marked.page.title()).startsWith('<img src=x'))
  assert.deepEqual(marked.faults, [])
  await marked.close()
  console.log('ok   text that looks like HTML is shown as text')

  writeFileSync(`${folder}/fails.ngc`, 'G21 G90 G94\nG1 X0 Y0 Z0 A0 C0 F600\nG1 X20\nG0 Z30\nG1 X30 F600\nG0 X0\nG1 X500 F600\n')
  const done = report(trunnion, [`${folder}/fails.ngc`, '-m', 'xyzac-trt', '-q', '-o', `${folder}/fails.html`], [2])
  const code = /error ([A-Z]+\d+):/.exec(done.stderr)[1]
  const failed = await openPage(browser, `${folder}/fails.html`)
  const told = await failed.page.locator('.failure').innerText()
  assert.ok(told.includes(code) && told.includes('line 7'), told)
  assert.deepEqual(failed.faults, [])
  await failed.close()
  console.log('ok   a plan that fails says where and why')

  for (const machine of ['nutating-table', 'head-table', 'head-head']) {
    const example = `${root}/examples/02_sinumerik`
    report(trunnion, [`${example}/bracket.mpf`, '-m', machine, '--setup', `${example}/setup.toml`, '-q', '-o', `${folder}/${machine}.html`])
    const one = await openPage(browser, `${folder}/${machine}.html`), worst = await apartFromMachine(one.page)
    assert.ok(worst < 0.05, `${machine}: ${worst} mm apart`)
    assert.deepEqual(one.faults, [])
    await one.close()
  }
  console.log('ok   machines of every family are drawn where their axes are')

  report(trunnion, [`${root}/examples/04_prediction/blend.cls`, '-m', 'ucp710', '--setup', `${root}/examples/04_prediction/blend_setup.toml`, '-c', 'lavernhe-2006', '-q', '-o', `${folder}/two.html`])
  const two = await openPage(browser, `${folder}/two.html`)
  assert.equal(await two.page.locator('[aria-label="Which run the picture shows"] option').count(), 2)
  await two.page.locator('[aria-label="Which run the picture shows"]').selectOption('1')
  assert.equal(await two.page.evaluate(() => window.trunnion.state.run.label), 'Sinumerik 840D as in Lavernhe 2006')
  assert.equal(await two.page.locator('figure .note').allInnerTexts().then(t => t.join()), 'no jerk in the rows of Sinumerik 840D as in Lavernhe 2006')
  assert.deepEqual(two.faults, [])
  await two.close()
  console.log('ok   a second run lies over the first, and a chart says what that run does not know')

  // The same part with half the feed before the change: twice the time, and the same way.
  const slower = `${folder}/slower.ngc`
  writeFileSync(slower, readFileSync(blade, 'utf8').replace(/F(\d+)/g, (_, feed) => `F${feed / 2}`))
  report(trunnion, [blade, ...job, '--before', slower, '-o', `${folder}/before.html`])
  const both = await openPage(browser, `${folder}/before.html`)
  const seen = await both.page.evaluate(() => window.trunnion.state.runs.map(run => ({ label: run.label, end_s: run.end_s, way_mm: run.path.way.at(-1) })))
  assert.deepEqual(seen.map(run => run.label), ['plan', 'before: slower'])
  assert.ok(Math.abs(seen[0].end_s - summary.cycle_time_s) < 0.01 && seen[1].end_s > 1.1 * seen[0].end_s, JSON.stringify(seen))
  assert.ok(Math.abs(seen[0].way_mm - seen[1].way_mm) < 1e-3 * seen[0].way_mm, JSON.stringify(seen))
  assert.match(await both.page.locator('.summary').innerText(), /before: slower/)
  const drawnLines = await both.page.locator('figure').first().innerText()
  assert.ok(drawnLines.includes('plan') && drawnLines.includes('before: slower'), drawnLines)
  await both.page.locator('[aria-label="Which run the picture shows"]').selectOption('1')
  assert.equal(await both.page.locator('figure .note').count(), 0)
  assert.deepEqual(both.faults, [])
  await both.close()
  console.log('ok   the program as it was before lies over the plan')

  writeFileSync(`${folder}/curves.ngc`, 'G21 G90 G94 G64 P0.01\nG1 X0 Y0 Z0 A0 C0 F1200\nG5 I5 J5 P-5 Q5 X20 Y0\nG1 X30 E5\nG1 X31 E7\nG2 X40 Y9 I0 J9\n')
  writeFileSync(`${folder}/printer.toml`, readFileSync(`${root}/data/machines/xyzac-trt.toml`, 'utf8').replace('[words]', '[words]\nfollowing = ["E"]'))
  const curved = report(trunnion, [`${folder}/curves.ngc`, '-m', `${folder}/printer.toml`, '-q', '-o', `${folder}/curves.html`])
  assert.equal(curved.status, 0, curved.stderr)
  const bent = await openPage(browser, `${folder}/curves.html`)
  const highest = await bent.page.evaluate(() => { const { path } = window.trunnion.state.run; let y = 0; for (let i = 0; i < path.count; ++i) if (path.line[i] === 3) y = Math.max(y, path.tip[3 * i + 1]); return y })
  assert.ok(Math.abs(highest - 3.75) < 0.05, `the curve rises to ${highest} mm`)
  assert.deepEqual(bent.faults, [])
  await bent.close()
  console.log('ok   curves, and words of an axis that follows')
}

const browser = await openBrowser()
let failed = 0
try {
  const { page, faults, close } = await openPage(browser, `${folder}/blade.html`)
  for (const [name, test] of Object.entries(tests)) {
    try {
      await test(page)
      console.log(`ok   ${name}`)
    } catch (error) {
      ++failed
      console.log(`FAIL ${name}\n     ${error.message}`)
    }
  }
  assert.deepEqual(faults, [], 'the console is not silent')
  await close()
  await others(browser)
} catch (error) {
  ++failed
  console.log(`FAIL ${error.stack}`)
} finally {
  await browser.close()
}
leave(failed ? 1 : 0)
