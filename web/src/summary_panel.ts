// What the run came to: where the time goes, where the feed falls, what is worth changing, what was assumed.
import { axisColour, causeColour } from './colours'
import type { FeedDrop, Finding, Summary } from './content'
import { element, fixed, seconds, short } from './element'
import type { State } from './state'

const section = (title: string, ...children: (Node | null)[]) => element('section', {}, element('h2', {}, title), ...children)

function bar(share: number, colour: string): HTMLElement {
  return element('span', { class: 'meter' }, element('i', { style: { width: `${100 * Math.min(1, Math.max(0, share))}%`, background: colour } }))
}

function facts(rows: [string, Node | string][]): HTMLElement {
  return element('dl', {}, ...rows.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]))
}

export class SummaryPanel {
  readonly root = element('aside', { class: 'summary', 'aria-label': 'Summary' })
  /** In the order of the table. */
  readonly drops: FeedDrop[]

  constructor(private readonly state: State, private readonly jumpToDrop: (drop: FeedDrop) => void) {
    const { summary, failure } = state.content
    this.drops = [...summary?.feed_drops ?? []].sort((a, b) => b.lost_s - a.lost_s)
    this.root.append(...[
      failure ? this.failure() : null,
      summary ? this.time(summary) : null,
      this.causes(),
      this.others(),
      summary ? this.loads(summary) : null,
      summary ? this.dropTable() : null,
      summary ? this.worth(summary) : null,
      summary ? this.findings(summary.diagnostics) : null,
      this.assumed(summary)
    ].filter(part => part !== null))
    state.on(['dark'], () => this.root.querySelector('.causes')!.replaceWith(this.causes()))
  }

  private failure(): HTMLElement {
    const f = this.state.content.failure!
    const where = f.line ? element('button', { type: 'button', class: 'link', onclick: () => this.state.moveTo(this.state.runs[0].end_s) }, `line ${f.line}`) : null
    return element('section', { class: 'failure', role: 'alert' }, element('h2', {}, 'The plan ends here'),
      element('p', {}, element('b', {}, f.code), ' ', where, where ? ': ' : '', f.text),
      f.value ? element('p', {}, `value ${f.value}${f.limit ? `, limit ${f.limit}` : ''}`) : null,
      f.hint ? element('p', {}, f.hint) : null,
      element('p', {}, `Shown is what was planned before: ${seconds(this.state.runs[0].end_s)}, ${this.state.runs[0].content.rows} setpoints.`))
  }

  private time(s: Summary): HTMLElement {
    const total = s.cycle_time_s || 1
    const parts: [string, number, string][] = [['cutting', s.cut_time_s, '#56b4e9'], ['rapid', s.rapid_time_s, '#9aa5b4'], ['dwell', s.dwell_time_s, '#cc79a7']]
    const stops = Object.entries(s.exact_stops ?? {}).filter(([name, n]) => name !== 'total' && n > 0).map(([name, n]) => `${n} ${name}`).join(', ')
    const tolerance = Number(s.options['tip_tolerance_mm']), angle = Number(s.options['orientation_tolerance_deg']), flank = Number(s.options['flank_tolerance_mm'])
    const verdict = element('span', { class: s.usable ? 'good' : 'bad' }, s.usable ? 'all limits and tolerances hold' : 'NOT USABLE: a limit or tolerance is broken')
    return section('Cycle time',
      element('p', { class: 'big' }, element('output', { 'data-value': 'cycle_time_s' }, seconds(s.cycle_time_s)), verdict),
      element('div', { class: 'split', role: 'img', 'aria-label': parts.map(([n, t]) => `${n} ${seconds(t)}`).join(', ') },
        ...parts.filter(([, t]) => t > 0).map(([, t, colour]) => element('i', { style: { width: `${100 * t / total}%`, background: colour } }))),
      element('p', { class: 'key' }, ...parts.map(([name, t, colour]) => element('span', {}, element('i', { style: { background: colour } }), `${name} `, element('b', { 'data-value': `${name}_time_s` }, seconds(t))))),
      facts([
        ['without jerk limits', `${seconds(s.jerk_free_bound_s ?? NaN)} (${fixed(100 * (1 - (s.jerk_free_bound_s ?? NaN) / total), 1)} % less)`],
        ['path', `${fixed(s.path_length_mm, 1)} mm, ${s.blocks} blocks, ${s.setpoints} setpoints`],
        ['tip deviation', element('span', {}, bar((s.tip_deviation_mm ?? 0) / (tolerance || 1), '#009e73'), ` ${fixed((s.tip_deviation_mm ?? 0) * 1000, 1)} of ${short(tolerance * 1000)} µm`)],
        flank > 0
          ? ['at the flank', element('span', {}, bar((s.height_deviation_mm ?? 0) / flank, '#009e73'), ` ${fixed((s.height_deviation_mm ?? 0) * 1000, 1)} of ${short(flank * 1000)} µm`)]
          : ['orientation', element('span', {}, bar((s.orientation_deviation_deg ?? 0) / (angle || 1), '#009e73'), ` ${fixed(s.orientation_deviation_deg, 3)} of ${short(angle)}°`)],
        ['exact stops', `${s.exact_stops?.total ?? 0}${stops ? `: ${stops}` : ''}`]
      ]))
  }

  private causes(): HTMLElement {
    const run = this.state.runs[0], time = run.timeByCause(), total = time.reduce((a, b) => a + b, 0)
    const rows = run.content.causes.map((name, k) => ({ name, time: time[k] })).filter(r => r.time > 0).sort((a, b) => b.time - a.time)
    const most = rows[0]?.time ?? 1, axes = this.state.content.machine.axes, dark = this.state.get('dark')
    const out = section('What limits the cut', element('table', {}, element('tbody', {}, ...rows.slice(0, 9).map(r => element('tr', {},
      element('td', {}, r.name), element('td', { class: 'wide' }, bar(r.time / most, causeColour(r.name, axes, dark))), element('td', { class: 'n' }, `${fixed(r.time, 2)} s`),
      element('td', { class: 'n' }, `${fixed(100 * r.time / (total || 1), 0)} %`))))))
    out.classList.add('causes')
    return out
  }

  private others(): HTMLElement | null {
    if (this.state.runs.length < 2) return null
    const times = [this.state.content.summary, ...this.state.content.others], first = times[0]?.cycle_time_s ?? this.state.runs[0].end_s
    return section('Compared', element('table', {}, element('thead', {}, element('tr', {}, ...['run', 'time', 'against the plan'].map(t => element('th', {}, t)))),
      element('tbody', {}, ...this.state.runs.map((run, k) => {
        const time = times[k]?.cycle_time_s ?? run.end_s, doubt = times[k]?.uncertainty_s
        return element('tr', {}, element('td', {}, run.label), element('td', { class: 'n' }, seconds(time) + (doubt ? ` ± ${fixed(doubt, 2)}` : '')),
          element('td', { class: 'n' }, k ? `${time >= first ? '+' : '−'}${fixed(Math.abs(100 * (time / first - 1)), 1)} %` : ''))
      }))))
  }

  private loads(s: Summary): HTMLElement {
    const axes = this.state.content.machine.axes
    return section('Axes: peak of the limit, and share of the cut in which it limits', element('table', { class: 'loads' },
      element('thead', {}, element('tr', {}, ...['', 'velocity', 'acceleration', 'jerk', 'limits'].map(t => element('th', {}, t)))),
      element('tbody', {}, ...axes.map((a, k) => {
        const load = s.axes[a.letter]
        const cell = (ratio: number | undefined) => element('td', {}, bar(ratio ?? 0, axisColour(k)), element('span', { class: 'n' }, ` ${fixed(100 * (ratio ?? NaN), 0)} %`))
        return element('tr', {}, element('th', { scope: 'row' }, a.letter), cell(load?.velocity_ratio), cell(load?.acceleration_ratio), cell(load?.jerk_ratio),
          element('td', { class: 'n', 'data-value': `limiting_share_${a.letter}` }, `${fixed(100 * (load?.limiting_share ?? NaN), 1)} %`))
      }))))
  }

  private dropTable(): HTMLElement {
    const rows = this.drops.map((d, k) => {
      const go = () => this.jumpToDrop(d)
      return element('tr', { class: 'drop', tabIndex: 0, 'data-drop': k, 'data-line': d.line, onclick: go, onkeydown: (e: KeyboardEvent) => { if (e.key === 'Enter') go() } },
        element('td', { class: 'n' }, d.line), element('td', { class: 'n' }, `${short(d.feed_min_mm_min)} of ${short(d.programmed_feed_mm_min)}`),
        element('td', {}, d.cause + (d.at_tolerance ? ' *' : '')), element('td', { class: 'n' }, `${fixed(d.lost_s, 3)} s`))
    })
    const starred = this.drops.some(d => d.at_tolerance)
    return section(`Where the feed falls (${rows.length})`, rows.length
      ? element('div', { class: 'tall' }, element('table', { class: 'drops' },
        element('thead', {}, element('tr', {}, ...['line', 'mm/min', 'because of', 'lost'].map(t => element('th', {}, t)))), element('tbody', {}, ...rows)))
      : element('p', {}, 'Nowhere under nine tenths of what is programmed.'),
    starred ? element('p', { class: 'note' }, '* the block transition uses up its tolerance: more of it would help') : null)
  }

  private worth(s: Summary): HTMLElement {
    const worth = (s.worth ?? []).filter(w => (w.saves_s ?? 0) >= 0.001), most = worth[0]?.saves_s ?? 1
    if (!s.worth?.length) return section('What is worth changing', element('p', {}, 'Not asked for: the option --worth finds out what more of each limit would save.'))
    return section('What is worth changing', worth.length
      ? element('table', { class: 'worth' }, element('tbody', {}, ...worth.slice(0, 12).map(w => element('tr', {}, element('td', {}, w.what), element('td', { class: 'n' }, w.change),
        element('td', { class: 'wide' }, bar((w.saves_s ?? 0) / most, '#e69f00')), element('td', { class: 'n' }, `saves ${fixed(w.saves_s, 3)} s`)))))
      : element('p', {}, 'No limit and no tolerance saves as much as a millisecond.'))
  }

  private findings(findings: Finding[]): HTMLElement {
    return section('Warnings', findings.length
      ? element('ul', { class: 'findings' }, ...findings.map(f => element('li', {}, element('b', {}, f.code), ' ', f.line ? `line ${f.line}: ` : '', f.text,
        (f.count ?? 1) > 1 ? ` (${f.count} times)` : '', f.hint ? element('small', {}, f.hint) : null)))
      : element('p', {}, 'None.'))
  }

  private assumed(s: Summary | null): HTMLElement {
    const { machine, setup, command } = this.state.content, o = s?.options ?? {}
    const tool = this.state.runs[0].content.tools[0]
    const rows: [string, Node | string][] = [
      ['machine', `${machine.name}, ${machine.chain.map(i => machine.axes[i].letter).join(' ')} from workpiece to tool`],
      ['setup', setup.file ? setup.file : 'none: program zero at the machine zero, tool length 0']
    ]
    if (tool) rows.push(['tool', `${tool.name ? `${tool.name}: ` : ''}${tool.kind} ${short(tool.diameter_mm)} mm, length ${short(tool.length_mm)} mm`])
    if (s) rows.push(['tolerances', `tip ${short(Number(o['tip_tolerance_mm']) * 1000)} µm, ` + (Number(o['flank_tolerance_mm']) > 0
      ? `${short(Number(o['flank_tolerance_mm']) * 1000)} µm at ${o['flank_height_mm']} mm up the flank` : `tool axis ${short(Number(o['orientation_tolerance_deg']))}°`)],
    ['rounding', `${o['rounding']}, calm ${o['calm']}, feed override ${fixed(100 * Number(o['feed_override']), 0)} %`],
    ['period', `${short(Number(o['period_s']) * 1000)} ms`])
    rows.push(['not covered', 'servo loops, backlash, gravity, heat, collision: setpoints are ideal positions'])
    const copy = element('button', { type: 'button', class: 'chip', onclick: () => { void navigator.clipboard?.writeText(command) } }, 'copy')
    return section('What was assumed', facts(rows), element('p', { class: 'command' }, element('code', {}, command), copy))
  }
}
