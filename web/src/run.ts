// One motion: rows of time in buckets, and the tool path as a polyline.
import { column, type AxisQuantity, type Numbers, type PathQuantity, type RangePlace, type RunContent, type ToolQuantity } from './content'

/** Least and greatest value of every bucket; the same array where a bucket is one row. */
export interface Range { least: Float32Array; greatest: Float32Array; blocks?: Range }

/** First index whose value is above x; values ascending. */
export function upperBound(values: Numbers, x: number): number {
  let low = 0, high = values.length
  while (low < high) {
    const middle = (low + high) >> 1
    if (values[middle] <= x) low = middle + 1
    else high = middle
  }
  return low
}

/** The last index whose value is not above x, at least 0. */
export const indexAt = (values: Numbers, x: number) => Math.max(0, upperBound(values, x) - 1)

export class Run {
  readonly time: Float64Array
  readonly way: Float32Array
  readonly line: Int32Array
  readonly cause: Uint8Array
  readonly rapid: Uint8Array
  readonly path: {
    count: number; time: Float64Array; way: Float64Array; tip: Float32Array; axis: Int16Array
    line: Int32Array; cause: Uint8Array; rapid: Uint8Array
    /** Indices of the places that are enough while the picture moves. */
    coarse: Int32Array
  }
  private readonly ranges = new Map<RangePlace, Range>()

  constructor(readonly content: RunContent, private readonly bytes: ArrayBuffer) {
    const { buckets, path } = content
    this.time = column(bytes, buckets.time) as Float64Array
    this.way = column(bytes, buckets.way) as Float32Array
    this.line = column(bytes, buckets.line) as Int32Array
    this.cause = column(bytes, buckets.cause) as Uint8Array
    this.rapid = column(bytes, buckets.rapid) as Uint8Array
    this.path = {
      count: path.time.n,
      time: column(bytes, path.time) as Float64Array, way: column(bytes, path.way) as Float64Array,
      tip: column(bytes, path.tip) as Float32Array, axis: column(bytes, path.axis) as Int16Array,
      line: column(bytes, path.line) as Int32Array, cause: column(bytes, path.cause) as Uint8Array,
      rapid: column(bytes, path.rapid) as Uint8Array, coarse: column(bytes, path.coarse) as Int32Array
    }
  }

  get end_s() { return this.content.end_s }
  get label() { return this.content.label }
  get buckets() { return this.time.length }

  private range(place: RangePlace): Range {
    let found = this.ranges.get(place)
    if (!found) {
      const least = column(this.bytes, place.least) as Float32Array
      found = { least, greatest: place.greatest ? column(this.bytes, place.greatest) as Float32Array : least }
      this.ranges.set(place, found)
    }
    return found
  }
  axis(letter: string, quantity: AxisQuantity): Range { return this.range(this.content.buckets.axes[letter][quantity]) }
  tool(quantity: ToolQuantity): Range { return this.range(this.content.buckets[quantity]) }
  onPath(quantity: PathQuantity): Float32Array { return column(this.bytes, this.content.path[quantity]) as Float32Array }

  /** Where a moment lies among the buckets: index, and share of the way to the next. */
  place(time_s: number): { index: number; share: number } {
    const index = Math.min(indexAt(this.time, time_s), Math.max(0, this.buckets - 1))
    if (index + 1 >= this.buckets) return { index, share: 0 }
    const step = this.time[index + 1] - this.time[index]
    return { index, share: step > 0 ? Math.min(1, Math.max(0, (time_s - this.time[index]) / step)) : 0 }
  }

  /** Middle of the bucket's range, straight between buckets of one row each. */
  valueAt(range: Range, time_s: number): number {
    if (this.buckets === 0) return NaN
    const { index, share } = this.place(time_s)
    const middle = (i: number) => (range.least[i] + range.greatest[i]) / 2
    if (share === 0) return middle(index)
    const from = middle(index), to = middle(index + 1)
    return Number.isFinite(to) ? from + (to - from) * share : from
  }

  lineAt(time_s: number): number { return this.buckets ? this.line[this.place(time_s).index] : 0 }
  causeAt(time_s: number): string { return this.buckets ? this.content.causes[this.cause[this.place(time_s).index]] : '' }
  wayAt(time_s: number): number {
    if (this.buckets === 0) return 0
    const { index, share } = this.place(time_s)
    return share ? this.way[index] + (this.way[index + 1] - this.way[index]) * share : this.way[index]
  }
  /** The moment at which the tip has gone so far. */
  timeAtWay(way_mm: number): number { return this.buckets ? this.time[indexAt(this.way, way_mm)] : 0 }

  /** Tip and tool axis at a moment: by the way between two places of the path, by time where the tip stands. */
  poseAt(time_s: number): { tip: [number, number, number]; axis: [number, number, number] } {
    const p = this.path
    if (p.count === 0) return { tip: [0, 0, 0], axis: [0, 0, 1] }
    const i = Math.min(indexAt(p.time, time_s), p.count - 1), k = Math.min(i + 1, p.count - 1)
    const way = p.way[k] - p.way[i], step = p.time[k] - p.time[i]
    const share = way > 0.01 ? (this.wayAt(time_s) - p.way[i]) / way : step > 0 ? (time_s - p.time[i]) / step : 0
    const u = Math.min(1, Math.max(0, share))
    const between = (values: Numbers, c: number) => values[3 * i + c] + (values[3 * k + c] - values[3 * i + c]) * u
    const axis = [0, 1, 2].map(c => between(p.axis, c))
    const norm = Math.hypot(...axis) || 1
    return {
      tip: [between(p.tip, 0), between(p.tip, 1), between(p.tip, 2)],
      axis: [axis[0] / norm, axis[1] / norm, axis[2] / norm]
    }
  }

  /** Places of the path in [from_s, to_s]. */
  placesBetween(from_s: number, to_s: number): [number, number] {
    return [Math.max(0, upperBound(this.path.time, from_s) - 1), Math.min(this.path.count, upperBound(this.path.time, to_s) + 1)]
  }

  toolAt(time_s: number) {
    const tools = this.content.tools
    let found = tools[0]
    for (const tool of tools) if (tool.from_s <= time_s) found = tool
    return found
  }

  /** Seconds by line of the program, by index = line. */
  timeByLine(lines: number): Float32Array {
    const out = new Float32Array(lines + 2)
    for (let i = 0; i < this.buckets; ++i) {
      const next = i + 1 < this.buckets ? this.time[i + 1] : this.end_s
      if (this.line[i] >= 0 && this.line[i] < out.length) out[this.line[i]] += next - this.time[i]
    }
    return out
  }
  /** Seconds of cutting by number of the cause. */
  timeByCause(): Float64Array {
    const out = new Float64Array(this.content.causes.length)
    for (let i = 0; i + 1 < this.buckets; ++i)
      if (!this.rapid[i]) out[this.cause[i]] += this.time[i + 1] - this.time[i]
    return out
  }
  /** When a line is first come to; NaN: never. */
  timeOfLine(line: number): number {
    const i = this.line.indexOf(line)
    return i < 0 ? NaN : this.time[i]
  }
}
