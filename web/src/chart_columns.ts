// What a line of a chart shows in each column of pixels: the least and the greatest value there, so that no peak is lost.
import { upperBound, type Range } from './run'

const perBlock = 64

/** Least and greatest of blocks of buckets, made once. */
function blocksOf(range: Range): Range {
  if (range.blocks) return range.blocks
  const count = Math.floor(range.least.length / perBlock)
  const least = new Float32Array(count).fill(Infinity), greatest = new Float32Array(count).fill(-Infinity)
  for (let b = 0; b < count; ++b)
    for (let i = b * perBlock; i < (b + 1) * perBlock; ++i) {
      if (range.least[i] < least[b]) least[b] = range.least[i]
      if (range.greatest[i] > greatest[b]) greatest[b] = range.greatest[i]
    }
  return range.blocks = { least, greatest }
}

/** Least and greatest value of buckets [first, last[; Infinity and −Infinity where nothing is known. */
export function extremes(range: Range, first: number, last: number): [number, number] {
  let least = Infinity, greatest = -Infinity
  const take = ({ least: low, greatest: high }: Range, from: number, to: number) => {
    for (let i = from; i < to; ++i) {
      if (low[i] < least) least = low[i]
      if (high[i] > greatest) greatest = high[i]
    }
  }
  const firstBlock = Math.ceil(first / perBlock), lastBlock = Math.floor(last / perBlock)
  if (firstBlock >= lastBlock) take(range, first, last)
  else {
    take(range, first, firstBlock * perBlock)
    take(blocksOf(range), firstBlock, lastBlock)
    take(range, lastBlock * perBlock, last)
  }
  return [least, greatest]
}

/** The part of an abscissa that is shown, and which buckets begin in each column: those from bounds[c] on, before bounds[c + 1]. */
export interface Columns { x: Float64Array | Float32Array; from: number; step: number; count: number; bounds: Uint32Array }

export function columnsOf(x: Float64Array | Float32Array, from: number, to: number, count: number): Columns {
  const step = (to - from) / count
  return { x, from, step, count, bounds: Uint32Array.from({ length: count + 1 }, (_, c) => upperBound(x, from + c * step)) }
}

/** Two values a column, that nearer to where the line comes from first, so that it does not jump to and fro; straight between two
 *  buckets where none begins in a column; NaN: nothing known. */
export function valuesIn(columns: Columns, range: Range, scale: number): Float64Array {
  const { x, from, step, count, bounds } = columns, out = new Float64Array(2 * count)
  const between = (c: number): [number, number] => {
    const next = bounds[c + 1]
    if (next === 0 || next >= x.length) return [NaN, NaN]
    const way = x[next] - x[next - 1], share = way > 0 ? (from + (c + 0.5) * step - x[next - 1]) / way : 0
    const mix = (v: Float32Array) => v[next - 1] + (v[next] - v[next - 1]) * share
    return [mix(range.least), mix(range.greatest)]
  }
  let before = NaN
  for (let c = 0; c < count; ++c) {
    let [least, greatest] = extremes(range, bounds[c], bounds[c + 1])
    if (least > greatest) [least, greatest] = between(c)
    const falling = Math.abs(before - greatest) < Math.abs(before - least)
    before = falling ? least : greatest
    out[2 * c] = (falling ? greatest : least) * scale
    out[2 * c + 1] = before * scale
  }
  return out
}

/** Draws what valuesIn() gives into a box of pixels; `yOf`: of a value. */
export function strokeColumns(ctx: CanvasRenderingContext2D, values: Float64Array, left: number, width: number, yOf: (value: number) => number) {
  const column = 2 * width / values.length
  let open = false
  ctx.beginPath()
  const to = (x: number, y: number) => { if (open) ctx.lineTo(x, y); else ctx.moveTo(x, y); open = true }
  for (let k = 0; k < values.length; k += 2) {
    const x = left + column * k / 2
    if (Number.isNaN(values[k])) { open = false; continue }
    const one = yOf(values[k]), two = yOf(values[k + 1])
    // One point where two would lie on each other.
    if (Math.abs(one - two) < 0.5) to(x + 0.5 * column, (one + two) / 2)
    else {
      to(x + 0.25 * column, one)
      to(x + 0.75 * column, two)
    }
  }
  ctx.stroke()
}
