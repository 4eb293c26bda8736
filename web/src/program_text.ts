// The program's text, of any length: only the lines in sight are elements. The bar before a line says what time it takes.
import { element } from './element'
import type { Run } from './run'
import type { State } from './state'

const lineHeight_px = 18
/** Browsers do not scroll through much more. */
const mostHeight_px = 8e6

export class ProgramText {
  readonly root = element('section', { class: 'program', 'aria-label': 'Program text' })
  private readonly scroller = element('div', { class: 'scroller', tabIndex: 0, role: 'listbox', 'aria-label': 'Lines of the program' })
  private readonly sheet = element('div', { class: 'sheet' })
  private readonly begins: Uint32Array
  private readonly decoder = new TextDecoder()
  private readonly time: Float32Array
  private readonly longest: number
  private readonly drops: Set<number>
  private current = 0
  private wanted = false
  private following = true
  private room = 0

  constructor(private readonly state: State, private readonly bytes: Uint8Array) {
    this.begins = ProgramText.lineBegins(bytes)
    this.time = state.runs[0].timeByLine(this.lines)
    const sorted = Float32Array.from(this.time).sort()
    this.longest = Math.max(1e-6, sorted[Math.max(0, sorted.length - 1 - Math.floor(sorted.length / 200))])
    this.drops = new Set((state.content.summary?.feed_drops ?? []).map(d => d.line))
    this.sheet.style.height = `${Math.min(this.lines * lineHeight_px, mostHeight_px)}px`
    this.scroller.append(this.sheet)
    this.root.append(element('h2', {}, state.content.program || 'Program', element('small', {}, `${this.lines} lines`)), this.scroller)
    this.scroller.addEventListener('scroll', () => this.draw())
    this.sheet.addEventListener('click', event => {
      const line = Number((event.target as HTMLElement).closest<HTMLElement>('[data-line]')?.dataset.line)
      if (line) this.goTo(line)
    })
    state.on(['cursor_s', 'run'], () => { this.following = true; this.draw() })
    new ResizeObserver(([entry]) => { this.room = entry.contentRect.height; this.draw() }).observe(this.scroller)
  }

  private static lineBegins(bytes: Uint8Array): Uint32Array {
    let count = 1
    for (let i = 0; i < bytes.length; ++i) if (bytes[i] === 10) ++count
    const begins = new Uint32Array(count + 1)
    let k = 1
    for (let i = 0; i < bytes.length; ++i) if (bytes[i] === 10) begins[k++] = i + 1
    begins[count] = bytes.length + 1
    return begins
  }

  get lines() {
    const count = this.begins.length - 1
    return count > 1 && this.begins[count - 1] >= this.bytes.length ? count - 1 : count
  }
  /** From 1 on. */
  line(number: number): string {
    if (number < 1 || number > this.lines) return ''
    return this.decoder.decode(this.bytes.subarray(this.begins[number - 1], this.begins[number] - 1)).replace(/\r$/, '')
  }

  /** Of a run of another program: nothing. */
  lineOf(run: Run, number: number): string { return this.isOf(run) ? this.line(number) : '' }
  private isOf(run: Run) { return run.content.program === this.state.runs[0].content.program }

  /** To where the line, or the next one that moves, is first come to. */
  goTo(line: number) {
    for (let k = line; k <= this.lines; ++k) {
      if (this.time[k] === 0) continue
      const time_s = this.state.runs[0].timeOfLine(k)
      if (Number.isFinite(time_s)) { this.state.moveTo(time_s); return }
    }
  }

  private get ratio() {
    const full = this.lines * lineHeight_px
    return full > mostHeight_px ? (full - this.room) / (mostHeight_px - this.room) : 1
  }

  /** The current line comes into sight. */
  private follow() {
    if (!this.isOf(this.state.run)) return
    this.current = this.state.run.lineAt(this.state.get('cursor_s'))
    const top = this.scroller.scrollTop * this.ratio, at = (this.current - 1) * lineHeight_px
    if (at < top + 2 * lineHeight_px || at > top + this.room - 3 * lineHeight_px)
      this.scroller.scrollTop = Math.max(0, at - this.room / 3) / this.ratio
  }

  private draw() {
    if (this.wanted) return
    this.wanted = true
    requestAnimationFrame(() => { this.wanted = false; this.drawNow() })
  }

  private drawNow() {
    if (this.room === 0) return
    if (this.following) this.follow()
    this.following = false
    const top = this.scroller.scrollTop * this.ratio, first = Math.max(1, Math.floor(top / lineHeight_px))
    const last = Math.min(this.lines, first + Math.ceil(this.room / lineHeight_px) + 2)
    const shift = this.scroller.scrollTop - top
    const rows: Node[] = []
    for (let k = first; k <= last; ++k) {
      const row = element('div', { class: k === this.current ? 'line current' : 'line', role: 'option', 'aria-selected': k === this.current ? 'true' : 'false' },
        element('span', { class: 'bar', title: this.time[k] > 0 ? `${this.time[k].toFixed(3)} s` : '',
          style: { width: `${Math.round(26 * Math.min(1, this.time[k] / this.longest))}px` } }),
        element('span', { class: this.drops.has(k) ? 'number drop' : 'number' }, String(k)), element('code', {}, this.line(k)))
      row.dataset.line = String(k)
      row.style.top = `${(k - 1) * lineHeight_px + shift}px`
      rows.push(row)
    }
    this.sheet.replaceChildren(...rows)
  }
}
