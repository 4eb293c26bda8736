// What all parts of the page look at together.
import type { Content } from './content'
import type { Run } from './run'

export const colourings = ['feed', 'cause', 'deviation', 'contact', 'turn', 'neighbour'] as const
export type Colouring = (typeof colourings)[number]
export type Frame = 'part' | 'machine'
export type Abscissa = 'time' | 'way'

interface Values {
  cursor_s: number
  /** Shown in charts and picture, s. */
  window: [number, number]
  colouring: Colouring
  frame: Frame
  abscissa: Abscissa
  dark: boolean
  /** Index of the run that cursor, picture and text belong to. */
  run: number
  ribbon: boolean
  height_mm: number
}
type Key = keyof Values

export class State {
  private readonly values: Values
  private readonly listeners = new Map<Key, (() => void)[]>()

  constructor(readonly content: Content, readonly runs: Run[], dark: boolean) {
    const height = Number(content.summary?.options['flank_height_mm'] ?? 30)
    this.values = {
      cursor_s: 0, window: [0, this.end_s], colouring: 'feed', frame: 'part', abscissa: 'time', dark, run: 0, ribbon: false,
      height_mm: height
    }
  }

  get<K extends Key>(key: K): Values[K] { return this.values[key] }
  set<K extends Key>(key: K, value: Values[K]) {
    if (this.values[key] === value) return
    this.values[key] = value
    for (const listener of this.listeners.get(key) ?? []) listener()
  }
  /** Called at every change of one of the keys. */
  on(keys: Key[], listener: () => void) {
    for (const key of keys) this.listeners.set(key, [...(this.listeners.get(key) ?? []), listener])
  }

  get run(): Run { return this.runs[this.values.run] }
  get end_s() { return Math.max(1e-9, ...this.runs.map(run => run.end_s)) }

  moveTo(time_s: number) { this.set('cursor_s', Math.min(this.run.end_s, Math.max(0, time_s))) }
  show(from_s: number, to_s: number) {
    const width = Math.min(this.end_s, Math.max(to_s - from_s, this.end_s * 1e-6, 0.004))
    const from = Math.min(Math.max(0, from_s), this.end_s - width)
    this.set('window', [from, from + width])
  }
  zoom(factor: number) {
    const [from, to] = this.values.window, middle = Math.min(to, Math.max(from, this.values.cursor_s))
    this.show(middle - (middle - from) * factor, middle + (to - middle) * factor)
  }
}
