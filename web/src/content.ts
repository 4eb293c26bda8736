// What the program wrote into the page: texts and figures as JSON, columns of numbers as deflated bytes.

export interface ColumnPlace { at: number; n: number; type: 'f32' | 'f64' | 'i32' | 'i16' | 'u8' }
export interface RangePlace { least: ColumnPlace; greatest?: ColumnPlace }
export type AxisQuantity = 'position' | 'velocity' | 'acceleration' | 'jerk'
export type ToolQuantity = 'feed' | 'programmed' | 'contact' | 'deviation' | 'turn'
export type PathQuantity = ToolQuantity | 'neighbour'

export interface AxisLimits { velocity: number; acceleration: number; jerk: number }
/** Lengths in mm, angles in degrees. */
export interface AxisContent {
  letter: string; rotary: boolean; reversed: boolean; direction: number[]; point_mm: number[]
  range: (number | null)[]; limits: AxisLimits; rapid_limits: AxisLimits
}
export interface MachineContent { name: string; file: string; axes: AxisContent[]; chain: number[] }
export interface SetupContent { file: string; origin_mm: number[]; rotation: number[][] }
export interface ToolContent {
  from_s: number; name: string; kind: 'flat' | 'ball' | 'torus' | 'taper'
  diameter_mm: number; corner_radius_mm: number; length_mm: number
}
export interface Finding { code: string; severity?: string; line?: number; text: string; value?: string; limit?: string; hint?: string; count?: number }

export interface FeedDrop {
  line: number; s_from_mm: number; s_to_mm: number; feed_min_mm_min: number; programmed_feed_mm_min: number
  lost_s: number; cause: string; at_tolerance?: boolean
}
export interface Worth { what: string; change: string; saves_s: number | null; gradient_s: number | null }
export interface AxisLoad {
  velocity_ratio: number; acceleration_ratio: number; jerk_ratio?: number; jerk_rms?: number; limiting_share: number
}
/** As `trunnion plan --summary` writes it; of a prediction only what both have. */
export interface Summary {
  program: string; dialect: string; machine: string; setup: string; controller: string | null
  options: Record<string, unknown>; usable?: boolean
  cycle_time_s: number; cut_time_s: number; rapid_time_s: number; dwell_time_s: number
  tool_change_time_s?: number; other_stop_time_s?: number; uncertainty_s?: number | null
  path_length_mm: number; blocks: number; setpoints?: number; period_s?: number; jerk_free_bound_s?: number
  tip_deviation_mm?: number; orientation_deviation_deg?: number; height_deviation_mm?: number; tolerance_used?: number
  exact_stops?: Record<string, number>; standstills?: number
  axes: Record<string, AxisLoad>; calm?: { weight: number; price_s: number | null }
  feed_drops: FeedDrop[]; worth?: Worth[]; diagnostics: Finding[]
}

export interface RunContent {
  label: string; program: string; rows: number; end_s: number; causes: string[]; tools: ToolContent[]
  buckets: {
    rows_per_bucket: number; time: ColumnPlace; way: ColumnPlace; line: ColumnPlace; cause: ColumnPlace; rapid: ColumnPlace
    axes: Record<string, Record<AxisQuantity, RangePlace>>
  } & Record<ToolQuantity, RangePlace>
  path: Record<'time' | 'way' | 'tip' | 'axis' | 'line' | 'cause' | 'rapid' | 'coarse' | PathQuantity, ColumnPlace>
}

export interface Content {
  program: string; command: string; machine: MachineContent; setup: SetupContent
  summary: Summary | null; others: (Summary | null)[]; failure: (Finding & { file: string }) | null
  events: { time_s: number; line: number; word: string }[]
  runs: RunContent[]; text: ColumnPlace; bytes: number
}

export function readContent(): Content {
  const element = document.getElementById('content')!
  const content = JSON.parse(element.textContent!) as Content
  element.remove()
  return content
}

/** Leaves the browser to itself, so that it stays at hand. */
export const pause = () => new Promise<void>(resolve => setTimeout(resolve))

function bytesOfBase64(text: string): Uint8Array<ArrayBuffer> {
  const native = (Uint8Array as { fromBase64?: (text: string) => Uint8Array<ArrayBuffer> }).fromBase64
  if (native) return native.call(Uint8Array, text)
  const characters = atob(text)
  const bytes = new Uint8Array(characters.length)
  for (let i = 0; i < characters.length; ++i) bytes[i] = characters.charCodeAt(i)
  return bytes
}

/** All columns, one behind the other; piece by piece with a pause behind each. */
export async function inflateColumns(size: number, told: (share: number) => void): Promise<ArrayBuffer> {
  const out = new Uint8Array(size)
  const stream = new DecompressionStream('deflate-raw')
  const reading = (async () => {
    const reader = stream.readable.getReader()
    for (let at = 0; ;) {
      const { done, value } = await reader.read()
      if (done) break
      out.set(value, at)
      at += value.length
    }
  })()
  const writer = stream.writable.getWriter()
  const pieces = [...document.querySelectorAll('script.columns')]
  for (const [i, piece] of pieces.entries()) {
    await writer.write(bytesOfBase64(piece.textContent!))
    piece.remove()
    told((i + 1) / pieces.length)
    await pause()
  }
  await writer.close()
  await reading
  return out.buffer
}

export type Numbers = Float32Array | Float64Array | Int32Array | Int16Array | Uint8Array

export function column(bytes: ArrayBuffer, place: ColumnPlace): Numbers {
  switch (place.type) {
    case 'f32': return new Float32Array(bytes, place.at, place.n)
    case 'f64': return new Float64Array(bytes, place.at, place.n)
    case 'i32': return new Int32Array(bytes, place.at, place.n)
    case 'i16': return new Int16Array(bytes, place.at, place.n)
    case 'u8': return new Uint8Array(bytes, place.at, place.n)
  }
}
