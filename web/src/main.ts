// The page of `trunnion report`.
import { Charts } from './charts'
import { titles } from './colouring'
import { column, inflateColumns, pause, readContent, type FeedDrop } from './content'
import { element, fixed, seconds, short } from './element'
import { openRenderer, Picture } from './picture'
import { ProgramText } from './program_text'
import { Run } from './run'
import { colourings, State, type Colouring } from './state'
import { SummaryPanel } from './summary_panel'

const speeds = [0.1, 0.25, 1, 4, 16, 64]

/** A row of buttons of which one is pressed. */
function choice<T extends string>(name: string, options: { value: T; text: string; title: string }[], now: () => T, chosen: (value: T) => void) {
  const buttons = options.map(o => element('button', { type: 'button', class: 'chip', title: o.title, [`data-${name}`]: o.value, onclick: () => chosen(o.value) }, o.text))
  const update = () => buttons.forEach((b, k) => b.setAttribute('aria-pressed', String(options[k].value === now())))
  update()
  return { root: element('div', { role: 'group', 'aria-label': name }, ...buttons), update }
}

function header(state: State, picture: Picture | null, help: HTMLDialogElement): HTMLElement {
  const { content } = state
  const colours = choice<Colouring>('colouring', colourings.map(c => ({ value: c, text: titles[c].name, title: `${titles[c].title} (${titles[c].key})` })),
    () => state.get('colouring'), c => state.set('colouring', c))
  state.on(['colouring'], colours.update)
  const frames = choice('frame', [{ value: 'part' as const, text: 'Part', title: 'The part stands still (m)' }, { value: 'machine' as const, text: 'Machine', title: 'The machine stands still, its axes move (m)' }],
    () => state.get('frame'), f => state.set('frame', f))
  state.on(['frame'], frames.update)
  const ribbon = element('button', { type: 'button', class: 'chip', 'data-ribbon': '', title: 'Tool axis as a ribbon of this height (r)', onclick: () => state.set('ribbon', !state.get('ribbon')) }, 'Ribbon')
  const height = element('input', { type: 'number', min: '1', max: '500', step: '1', value: String(state.get('height_mm')), 'aria-label': 'Height of the ribbon, mm',
    oninput: () => { const mm = Number(height.value); if (mm > 0) state.set('height_mm', mm) } })
  state.on(['height_mm'], () => { if (document.activeElement !== height) height.value = String(state.get('height_mm')) })
  state.on(['ribbon'], () => ribbon.setAttribute('aria-pressed', String(state.get('ribbon'))))
  ribbon.setAttribute('aria-pressed', 'false')
  const runs = element('select', { 'aria-label': 'Which run the picture shows', hidden: state.runs.length < 2, onchange: () => state.set('run', Number(runs.value)) },
    ...state.runs.map((run, k) => element('option', { value: String(k) }, run.label)))
  const theme = element('button', { type: 'button', class: 'chip', title: 'Dark or light (t)', onclick: () => state.set('dark', !state.get('dark')) }, 'Light / dark')
  const time = state.content.summary?.cycle_time_s ?? state.runs[0].end_s
  return element('header', { class: 'top' },
    element('h1', {}, content.program || 'Program', element('small', {}, content.machine.name)),
    element('output', { class: 'cycle' }, seconds(time)),
    picture ? element('div', { class: 'tools' }, colours.root, frames.root, element('div', {}, ribbon, height, ' mm')) : element('div', { class: 'tools' }),
    element('div', { class: 'tools right' }, runs, theme, element('button', { type: 'button', class: 'chip', title: 'Print the summary (p)', onclick: () => print() }, 'Print'),
      element('button', { type: 'button', class: 'chip', title: 'Keys (?)', onclick: () => help.showModal() }, '?')))
}

/** Lines of the program between which the picture shows the path. */
function section(state: State, text: ProgramText): HTMLElement {
  const from = element('input', { type: 'number', min: '1', max: String(text.lines), 'aria-label': 'Shown from line' })
  const to = element('input', { type: 'number', min: '1', max: String(text.lines), 'aria-label': 'Shown to line' })
  const apply = () => {
    const run = state.runs[0], first = Number(from.value) || 1, last = Number(to.value) || text.lines
    let begin = Infinity, end = -Infinity
    for (let i = 0; i < run.buckets; ++i)
      if (run.line[i] >= first && run.line[i] <= last) { begin = Math.min(begin, run.time[i]); end = Math.max(end, run.time[i + 1] ?? run.end_s) }
    if (begin < end) { state.show(begin, end); state.moveTo(Math.min(end, Math.max(begin, state.get('cursor_s')))) }
  }
  from.addEventListener('input', apply)
  to.addEventListener('input', apply)
  state.on(['window'], () => {
    const [begin, end] = state.get('window'), whole = begin <= 0 && end >= state.end_s
    if (document.activeElement !== from) from.value = whole ? '' : String(state.runs[0].lineAt(begin))
    if (document.activeElement !== to) to.value = whole ? '' : String(state.runs[0].lineAt(end))
  })
  return element('label', { class: 'section' }, 'lines ', from, ' … ', to)
}

class Player {
  private playing = false
  private last = 0
  private readonly button = element('button', { type: 'button', class: 'chip play', title: 'Play or stop (space)', onclick: () => this.toggle() }, '▶')
  private readonly speed = element('select', { 'aria-label': 'Speed' }, ...speeds.map(s => element('option', { value: String(s), selected: s === 1 }, `${s}×`)))
  private readonly slider = element('input', { type: 'range', min: '0', max: '1', step: 'any', 'aria-label': 'Time', oninput: () => this.state.moveTo(Number(this.slider.value) * this.state.run.end_s) })
  private readonly told = element('output', { class: 'told' })
  readonly root: HTMLElement

  constructor(private readonly state: State, lines: HTMLElement) {
    this.root = element('div', { class: 'player' }, this.button, this.speed, this.slider, this.told, lines)
    state.on(['cursor_s', 'run'], () => this.show())
    this.show()
  }
  toggle() {
    this.playing = !this.playing
    this.button.textContent = this.playing ? '❚❚' : '▶'
    if (!this.playing) return
    if (this.state.get('cursor_s') >= this.state.run.end_s) this.state.moveTo(0)
    this.last = performance.now()
    requestAnimationFrame(now => this.step(now))
  }
  private step(now: number) {
    if (!this.playing) return
    this.state.moveTo(this.state.get('cursor_s') + (now - this.last) / 1000 * Number(this.speed.value))
    this.last = now
    if (this.state.get('cursor_s') >= this.state.run.end_s) this.toggle()
    else requestAnimationFrame(next => this.step(next))
  }
  private show() {
    const { state } = this, run = state.run, time_s = state.get('cursor_s')
    this.slider.value = String(time_s / (run.end_s || 1))
    const feed = run.valueAt(run.tool('feed'), time_s), programmed = run.valueAt(run.tool('programmed'), time_s)
    this.told.replaceChildren(element('b', {}, `${fixed(time_s, 3)} s`), ` line `, element('b', { 'data-value': 'line' }, run.lineAt(time_s)), ` · ${short(feed)}`,
      Number.isFinite(programmed) ? ` of ${short(programmed)}` : '', ' mm/min · ', run.causeAt(time_s))
  }
}

function helpDialog(): HTMLDialogElement {
  const keys: [string, string][] = [['← →', 'step along the time; with shift ten times as far'], ['[ ]', 'previous and next feed drop'], ['+ −', 'zoom the time'], ['0', 'all of the motion'],
    ['space', 'play or stop'], ['1 … 6', 'what the colours mean'], ['m', 'part or machine'], ['r', 'ribbon'], ['a d w s', 'turn the picture'], ['f', 'fit the picture'], ['t', 'dark or light'], ['p', 'print the summary']]
  const dialog = element('dialog', { 'aria-label': 'Keys' }, element('h2', {}, 'Keys'), element('dl', {}, ...keys.flatMap(([key, what]) => [element('dt', {}, element('kbd', {}, key)), element('dd', {}, what)])),
    element('p', {}, 'Picture: drag turns, wheel zooms, right button shifts, a click goes there. Charts: drag zooms, wheel zooms about the cursor, double click shows all.'),
    element('form', { method: 'dialog' }, element('button', { class: 'chip' }, 'close')))
  return dialog
}

function watchKeys(state: State, player: Player, picture: Picture | null, drops: FeedDrop[], jump: (drop: FeedDrop) => void, help: HTMLDialogElement) {
  const inOrder = drops.map(drop => ({ drop, time_s: middleOfLoss(state.runs[0], drop) })).sort((a, b) => a.time_s - b.time_s)
  const nextDrop = (step: number) => {
    const now = state.get('cursor_s')
    const found = step > 0 ? inOrder.find(d => d.time_s > now + 1e-6) : inOrder.findLast(d => d.time_s < now - 1e-6)
    if (found) jump(found.drop)
  }
  const keys: Record<string, () => void> = {
    ' ': () => player.toggle(), '[': () => nextDrop(-1), ']': () => nextDrop(1), '+': () => state.zoom(0.5), '-': () => state.zoom(2), '0': () => state.show(0, state.end_s),
    m: () => state.set('frame', state.get('frame') === 'part' ? 'machine' : 'part'), r: () => state.set('ribbon', !state.get('ribbon')), f: () => picture?.fit(), a: () => picture?.turn(-6, 0), d: () => picture?.turn(6, 0), w: () => picture?.turn(0, 6), s: () => picture?.turn(0, -6),
    t: () => state.set('dark', !state.get('dark')), p: () => print(), '?': () => help.showModal()
  }
  for (const c of colourings) keys[titles[c].key] = () => state.set('colouring', c)
  addEventListener('keydown', event => {
    const target = event.target as HTMLElement
    if (event.ctrlKey || event.metaKey || event.altKey || help.open || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) return
    const [from, to] = state.get('window'), step = (to - from) / 200 * (event.shiftKey ? 10 : 1)
    if (event.key === 'ArrowRight') state.moveTo(state.get('cursor_s') + step)
    else if (event.key === 'ArrowLeft') state.moveTo(state.get('cursor_s') - step)
    else if (keys[event.key] && !(event.key === ' ' && target.tagName === 'BUTTON')) keys[event.key]()
    else return
    event.preventDefault()
  })
}

/** When half of what a feed drop loses is lost. */
function middleOfLoss(run: Run, drop: FeedDrop): number {
  const feed = run.tool('feed'), begin = run.place(run.timeAtWay(drop.s_from_mm)).index, end = run.place(run.timeAtWay(drop.s_to_mm)).index
  const lost = (i: number) => run.rapid[i] || i + 1 >= run.buckets ? 0 : Math.max(0, 1 - feed.least[i] / drop.programmed_feed_mm_min) * (run.time[i + 1] - run.time[i])
  let all = 0, so_far = 0
  for (let i = begin; i <= end; ++i) all += lost(i)
  for (let i = begin; i <= end; ++i) if ((so_far += lost(i)) >= all / 2) return run.time[i]
  return run.time[begin]
}

/** To the middle of a feed drop, with its surroundings. */
function jumpToDrop(state: State, drop: FeedDrop) {
  const run = state.runs[0], from = run.timeAtWay(drop.s_from_mm), to = Math.max(from, run.timeAtWay(drop.s_to_mm))
  state.set('run', 0)
  const width = Math.max(4 * (to - from), state.end_s / 200)
  state.show((from + to) / 2 - width / 2, (from + to) / 2 + width / 2)
  state.moveTo(middleOfLoss(run, drop))
}

async function start() {
  const wait = element('p', { class: 'wait', role: 'status' }, 'Unpacking …')
  document.body.append(wait)
  await pause()
  const renderer = openRenderer()
  await pause()
  const content = readContent()
  document.title = `${content.program} · Trunnion`
  const bytes = await inflateColumns(content.bytes, share => { wait.textContent = `Unpacking … ${Math.round(100 * share)} %` })
  const state = new State(content, content.runs.map(run => new Run(run, bytes)), matchMedia('(prefers-color-scheme: dark)').matches)
  const applyTheme = () => { document.documentElement.dataset.theme = state.get('dark') ? 'dark' : 'light' }
  applyTheme()
  state.on(['dark'], applyTheme)
  await pause()
  const text = new ProgramText(state, column(bytes, content.text) as Uint8Array)
  const help = helpDialog(), jump = (drop: FeedDrop) => jumpToDrop(state, drop)
  const picture = renderer && new Picture(state, text, renderer)
  const player = new Player(state, section(state, text))
  const view = picture?.root ?? element('section', { class: 'picture none' }, element('p', {}, 'No picture: this browser has no WebGL. Charts, tables and text are there.'))
  // The picture first; charts and tables have their room and come behind it.
  const chartsRoom = element('section', { class: 'charts' }), summaryRoom = element('section', { class: 'summary' })
  wait.replaceWith(element('div', { class: 'page' }, header(state, picture, help), text.root, element('main', {}, view, player.root, chartsRoom), summaryRoom), help)
  await picture?.ready
  document.documentElement.dataset.picture = ''
  const charts = new Charts(state)
  chartsRoom.replaceWith(charts.root)
  await pause()
  const summary = new SummaryPanel(state, jump), paper = element('img', { class: 'paper', alt: 'Tool path' })
  summaryRoom.replaceWith(summary.root)
  summary.root.prepend(paper)
  addEventListener('beforeprint', () => { if (picture) paper.src = picture.image() })
  watchKeys(state, player, picture, summary.drops, jump, help)
  await picture?.refine()
  Object.assign(window, { trunnion: { state, picture } })
  document.documentElement.dataset.ready = ''
}

start().catch(error => document.body.append(element('p', { class: 'wait', role: 'alert' }, `The page cannot be shown: ${String(error)}`)))
