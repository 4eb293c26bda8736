// Charts over time or over the tip's way, on one cursor. Whatever the number of rows, a chart gets two points a pixel: the least and
// the greatest value there.
import uPlot from 'uplot'
import { columnsOf, extremes, strokeColumns, valuesIn, type Columns } from './chart_columns'
import { axisColour } from './colours'
import type { AxisContent, AxisQuantity, ToolQuantity } from './content'
import { element, fixed, short } from './element'
import type { Range, Run } from './run'
import type { Abscissa, State } from './state'

interface Line { name: string; run: number; beside?: boolean; range: Range; scale: number; colour: string; dash?: number[]; unit: string; rotary?: boolean }
interface Chart { title: string; unit: string; lines: Line[]; limits: number[]; fromZero: boolean; notes: string[] }
interface Plotted { plot: uPlot; chart: Chart; values: HTMLElement[]; cursor: HTMLElement; shown: Float64Array[] }

const toolCharts: { key: ToolQuantity; name: string; title: string; unit: string }[] = [
  { key: 'feed', name: 'Feed', title: 'Path feed', unit: 'mm/min' },
  { key: 'contact', name: 'Contact feed', title: 'Feed at the contact point', unit: 'mm/min' },
  { key: 'deviation', name: 'Deviation', title: 'Distance from the programmed path', unit: 'µm' },
  { key: 'turn', name: 'Tilt rate', title: 'Turning of the tool axis', unit: '°/s' }
]
const axisCharts: { key: AxisQuantity; name: string; of: (unit: string) => string }[] = [
  { key: 'position', name: 'Position', of: u => u },
  { key: 'velocity', name: 'Velocity', of: u => `${u}/s` },
  { key: 'acceleration', name: 'Acceleration', of: u => `${u}/s²` },
  { key: 'jerk', name: 'Jerk', of: u => `${u}/s³` }
]
const dashes: (number[] | undefined)[] = [undefined, [6, 3], [2, 3], [8, 3, 2, 3]]

const isKnown = (range: Range) => { const [least, greatest] = extremes(range, 0, range.least.length); return least <= greatest }

const hasTwoScales = (chart: Chart) => chart.lines.some(l => l.rotary) && chart.lines.some(l => !l.rotary)

export class Charts {
  readonly root = element('section', { class: 'charts', 'aria-label': 'Charts' })
  private readonly stack = element('div', { class: 'stack' })
  private readonly shown = new Set<string>(['feed', 'velocity', 'jerk'])
  private readonly axesShown: Set<string>
  private plots: Plotted[] = []
  private stale: Plotted[] = []
  private moving = false
  private waiting = false
  private readonly resized: ResizeObserver

  constructor(private readonly state: State) {
    this.axesShown = new Set(state.content.machine.axes.map(a => a.letter))
    this.root.append(this.bar(), this.stack)
    this.resized = new ResizeObserver(() => this.build())
    this.resized.observe(this.stack)
    state.on(['dark', 'abscissa'], () => this.build())
    state.on(['window', 'run'], () => this.refresh())
    state.on(['cursor_s'], () => this.moveCursor())
  }

  private bar(): HTMLElement {
    const chip = (set: Set<string>, key: string, name: string, colour?: string) => {
      const button = element('button', { class: 'chip', type: 'button', 'aria-pressed': String(set.has(key)), 'data-chart': key,
        onclick: () => {
          if (!set.delete(key)) set.add(key)
          button.setAttribute('aria-pressed', String(set.has(key)))
          this.build()
        } }, colour ? element('i', { style: { background: colour } }) : null, name)
      return button
    }
    const over = element('button', { class: 'chip', type: 'button', title: 'Charts over time or over the way of the tip',
      onclick: () => {
        const to: Abscissa = this.state.get('abscissa') === 'time' ? 'way' : 'time'
        this.state.set('abscissa', to)
        over.textContent = to === 'time' ? 'over time' : 'over way'
      } }, 'over time')
    const whole = element('button', { class: 'chip', type: 'button', title: 'All of the motion (0)', onclick: () => this.state.show(0, this.state.end_s) }, 'whole')
    return element('div', { class: 'chips' },
      element('div', { role: 'group', 'aria-label': 'Charts' }, ...toolCharts.map(c => chip(this.shown, c.key, c.name)),
        ...axisCharts.map(c => chip(this.shown, c.key, c.name))),
      element('div', { role: 'group', 'aria-label': 'Axes' }, ...this.state.content.machine.axes.map((a, k) => chip(this.axesShown, a.letter, a.letter, axisColour(k)))),
      element('div', {}, over, whole))
  }

  private toolChart(key: ToolQuantity, title: string, unit: string): Chart {
    const ink = this.state.get('dark') ? '#e8ecf1' : '#1b2733', lines: Line[] = []
    this.state.runs.forEach((run, k) => {
      const more = this.state.runs.length > 1 ? `${run.label}` : title
      const colours = [ink, '#d55e00', '#56b4e9', '#009e73']
      lines.push({ name: more, run: k, range: run.tool(key), scale: 1, colour: colours[k % 4], dash: k ? dashes[k % 4] : undefined, unit })
    })
    if (key === 'feed')
      lines.unshift({ name: 'programmed', run: 0, range: this.state.runs[0].tool('programmed'), scale: 1, colour: this.state.get('dark') ? '#8b95a3' : '#8d96a3', dash: [5, 4], unit })
    return { title, unit, lines, limits: [], fromZero: true, notes: [] }
  }

  /** One axis in its unit, with its limits; several as shares of their limits. */
  private axisChart(key: AxisQuantity, name: string, unitOf: (unit: string) => string): Chart {
    const axes = this.state.content.machine.axes, chosen = axes.filter(a => this.axesShown.has(a.letter))
    const unit = (a: AxisContent) => unitOf(a.rotary ? '°' : 'mm'), asShare = key !== 'position' && chosen.length > 1
    const limits: Chart['limits'] = [], lines: Line[] = [], silent = this.state.runs.filter(run => !axes.some(a => isKnown(run.axis(a.letter, key))))
    for (const axis of chosen)
      this.state.runs.forEach((run, k) => {
        if (silent.includes(run)) return
        const limit = key === 'position' ? 1 : axis.limits[key]
        lines.push({ name: axis.letter, run: k, beside: k > 0, range: run.axis(axis.letter, key),
          scale: asShare ? 100 / limit : 1, colour: axisColour(axes.indexOf(axis)), dash: dashes[k % 4],
          unit: asShare ? '%' : unit(axis), rotary: key === 'position' && axis.rotary })
        if (key !== 'position' && !asShare && k === 0) limits.push(limit, -limit)
      })
    if (asShare) limits.push(100, -100)
    const label = key === 'position' ? 'mm · °' : asShare ? '% of the limit' : chosen.length ? unit(chosen[0]) : ''
    return { title: `${chosen.length === 1 ? chosen[0].letter + ' ' : ''}${chosen.length === 1 ? name.toLowerCase() : name}`, unit: label, lines, limits, fromZero: false,
      notes: silent.map(run => `no ${name.toLowerCase()} in the rows of ${run.label}`) }
  }

  private charts(): Chart[] {
    return [
      ...toolCharts.filter(c => this.shown.has(c.key)).map(c => this.toolChart(c.key, c.title, c.unit)),
      ...axisCharts.filter(c => this.shown.has(c.key)).map(c => this.axisChart(c.key, c.name, c.of))
    ]
  }

  private build() {
    const width = this.stack.clientWidth
    if (!width) return
    for (const { plot } of this.plots) plot.destroy()
    const charts = this.charts(), room = this.stack.clientHeight
    const height = Math.max(110, Math.floor(room / Math.max(1, charts.length)))
    this.plots = []
    this.stack.replaceChildren(...charts.map((chart, k) => this.one(chart, width, height - 22, k + 1 === charts.length)))
    this.refresh()
  }

  private abscissa(run: Run): Float64Array | Float32Array { return this.state.get('abscissa') === 'time' ? run.time : run.way }
  private toTime(x: number) { return this.state.get('abscissa') === 'time' ? x : this.state.run.timeAtWay(x) }
  private get window(): [number, number] {
    const [from, to] = this.state.get('window')
    if (this.state.get('abscissa') === 'time') return [from, to]
    return [this.state.run.wayAt(from), Math.max(this.state.run.wayAt(to), this.state.run.wayAt(from) + 1e-3)]
  }

  private one(chart: Chart, width: number, height: number, last: boolean): HTMLElement {
    const dark = this.state.get('dark'), ink = dark ? '#aeb7c2' : '#4a5563', grid = dark ? '#262c34' : '#e3e7ec'
    const values = chart.lines.map(() => element('b', {}))
    const head = element('header', {}, element('strong', {}, chart.title), element('small', {}, chart.unit),
      ...this.headOf(chart, values))
    const holder = element('div', { class: 'plot' }), twoScales = hasTwoScales(chart), scaleOf = (line: Line) => line.rotary && twoScales ? 'deg' : 'y'
    const ranged = (_: uPlot, least: number, greatest: number): [number, number] => {
      if (!Number.isFinite(least) || !Number.isFinite(greatest)) return [0, 1]
      const room = 0.06 * Math.max(greatest - least, 1e-6)
      return [chart.fromZero ? Math.min(0, least) : least - room, greatest + room]
    }
    const axis = { stroke: ink, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, width: 1, size: 4 }, font: '11px system-ui, sans-serif' }
    const plot: uPlot = new uPlot({
      width, height, legend: { show: false },
      padding: [6, twoScales ? 0 : 14, last ? 0 : 7, 0],
      scales: { x: { time: false }, y: { range: ranged }, deg: { range: ranged } },
      series: [{}, ...chart.lines.map(line => ({ scale: scaleOf(line), paths: () => null, points: { show: false } }))],
      axes: [
        { ...axis, show: last, size: last ? 26 : 0, values: (_: uPlot, ticks: number[]) => ticks.map(t => `${+t.toFixed(4)}${this.state.get('abscissa') === 'time' ? ' s' : ' mm'}`) },
        { ...axis, size: 54, space: 22 },
        ...(twoScales ? [{ ...axis, scale: 'deg', side: 1 as const, size: 44, grid: { show: false }, space: 22, values: (_: uPlot, ticks: number[]) => ticks.map(t => `${t}°`) }] : [])
      ],
      cursor: { x: false, y: false, points: { show: false }, drag: { x: true, y: false, setScale: false } },
      hooks: {
        draw: [u => this.drawLines(u, chart), u => this.drawLimits(u, chart)],
        setCursor: [u => { if (!this.moving && u.cursor.left !== undefined && u.cursor.left! >= 0 && this.hovered === u) this.state.moveTo(this.toTime(u.posToVal(u.cursor.left!, 'x'))) }],
        setSelect: [u => {
          if (u.select.width < 3) return
          const from = u.posToVal(u.select.left, 'x'), to = u.posToVal(u.select.left + u.select.width, 'x')
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false)
          this.state.show(this.toTime(from), this.toTime(to))
        }]
      }
    }, [[], ...chart.lines.map(() => [])] as unknown as uPlot.AlignedData, holder)
    plot.over.addEventListener('pointermove', () => { this.hovered = plot })
    plot.over.addEventListener('pointerleave', () => { this.hovered = null })
    plot.over.addEventListener('dblclick', () => this.state.show(0, this.state.end_s))
    plot.over.addEventListener('wheel', event => {
      event.preventDefault()
      this.state.moveTo(this.toTime(plot.posToVal(event.offsetX, 'x')))
      this.state.zoom(event.deltaY > 0 ? 1.25 : 0.8)
    }, { passive: false })
    const cursor = element('div', { class: 'now' })
    plot.over.append(cursor)
    this.plots.push({ plot, chart, values, cursor, shown: [] })
    return element('figure', {}, head, holder)
  }
  private hovered: uPlot | null = null

  /** Names and values at the cursor; of several runs the values side by side, and which dashes are whose. */
  private headOf(chart: Chart, values: HTMLElement[]): HTMLElement[] {
    const swatch = (colour: string, dashed: boolean) => element('i', { class: dashed ? 'dashed' : '', style: { color: colour } })
    const out: HTMLElement[] = []
    if (chart.lines.some(line => line.beside))
      this.state.runs.slice(1).forEach(run => out.push(element('span', {}, swatch('currentColor', true), run.label)))
    chart.lines.forEach((line, k) => {
      if (line.beside) out.at(-1)!.append('| ', values[k])
      else out.push(element('span', {}, swatch(line.colour, line.dash !== undefined), line.name, ' ', values[k]))
    })
    for (const note of chart.notes) out.push(element('span', { class: 'note', title: `${note}: they lie too far apart for it` }, note))
    return out
  }

  private drawLines(u: uPlot, chart: Chart) {
    const shown = this.plots.find(p => p.plot === u)?.shown ?? [], { left, top, width, height } = u.bbox, { ctx } = u
    ctx.save()
    ctx.beginPath()
    ctx.rect(left, top, width, height)
    ctx.clip()
    ctx.lineJoin = 'bevel'
    ctx.lineWidth = 1.3 * devicePixelRatio
    chart.lines.forEach((line, k) => {
      const { min = 0, max = 1 } = u.scales[line.rotary && hasTwoScales(chart) ? 'deg' : 'y']
      if (!shown[k]) return
      ctx.strokeStyle = line.colour
      ctx.setLineDash((line.dash ?? []).map(length => length * devicePixelRatio))
      strokeColumns(ctx, shown[k], left, width, value => top + height * (max - value) / (max - min))
    })
    ctx.restore()
  }

  private drawLimits(u: uPlot, chart: Chart) {
    const { left, top, width, height } = u.bbox
    u.ctx.save()
    u.ctx.setLineDash([6, 4])
    u.ctx.lineWidth = 1.3 * devicePixelRatio
    u.ctx.strokeStyle = this.state.get('dark') ? '#ff9d94' : '#b3261e'
    for (const limit of chart.limits) {
      const y = u.valToPos(limit, 'y', true)
      if (y < top || y > top + height) continue
      u.ctx.beginPath()
      u.ctx.moveTo(left, y)
      u.ctx.lineTo(left + width, y)
      u.ctx.stroke()
    }
    u.ctx.restore()
  }

  /** All charts, one a frame, so that the page stays at hand. */
  private refresh() {
    this.stale = [...this.plots]
    this.refreshSoon()
  }
  private refreshSoon() {
    if (this.waiting) return
    this.waiting = true
    requestAnimationFrame(() => {
      this.waiting = false
      const next = this.stale.shift()
      if (next) this.refreshOne(next)
      if (this.stale.length) this.refreshSoon()
      else this.tellValues()
    })
  }
  private refreshOne(one: Plotted) {
    const { plot, chart } = one, [from, to] = this.window, count = Math.max(50, Math.floor(plot.bbox.width / devicePixelRatio))
    const ofRuns = new Map<number, Columns>()
    const ofRun = (run: number) => {
      if (!ofRuns.has(run)) ofRuns.set(run, columnsOf(this.abscissa(this.state.runs[run]), from, to, count))
      return ofRuns.get(run)!
    }
    one.shown = chart.lines.map(line => valuesIn(ofRun(line.run), line.range, line.scale))
    // The chart needs to know no more than how far its values go.
    const reach = one.shown.map(values => {
      let least = Infinity, greatest = -Infinity
      for (const value of values) { if (value < least) least = value; if (value > greatest) greatest = value }
      return least <= greatest ? [least, greatest] : [null, null]
    })
    this.moving = true
    plot.batch(() => {
      plot.setData([[from, to], ...reach] as unknown as uPlot.AlignedData, true)
      plot.setScale('x', { min: from, max: to })
    })
    this.moving = false
    this.placeCursor(one)
  }

  private moveCursor() {
    const time_s = this.state.get('cursor_s'), [from, to] = this.state.get('window')
    if (time_s < from || time_s > to) this.state.show(time_s - (to - from) / 2, time_s + (to - from) / 2)
    for (const one of this.plots) this.placeCursor(one)
    this.tellValues()
  }
  private placeCursor({ plot, cursor }: Plotted) {
    const time_s = this.state.get('cursor_s'), x = this.state.get('abscissa') === 'time' ? time_s : this.state.run.wayAt(time_s)
    const [from, to] = this.window
    cursor.hidden = x < from || x > to
    cursor.style.transform = `translateX(${(x - from) / (to - from) * plot.over.clientWidth}px)`
  }
  private tellValues() {
    const time_s = this.state.get('cursor_s')
    for (const { chart, values } of this.plots)
      chart.lines.forEach((line, k) => {
        const run = this.state.runs[line.run]
        const at = this.state.get('abscissa') === 'time' ? time_s : run.timeAtWay(this.state.run.wayAt(time_s))
        const value = run.valueAt(line.range, Math.min(at, run.end_s)) * line.scale
        values[k].textContent = line.unit === '%' ? `${fixed(value, 0)} %` : short(value)
      })
  }
}
