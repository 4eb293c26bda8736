// What the path's colours mean: a scale for amounts, a list for causes.
import { amountColour, causeColour, cssOf, feedColour, rgbOf, type Rgb } from './colours'
import { short } from './element'
import type { Run } from './run'
import type { Colouring } from './state'
import type { AxisContent } from './content'

export interface Legend { title: string; unit: string; ramp?: string[]; ticks?: string[]; kinds?: { name: string; colour: string }[] }
export interface Painted { colour: (i: number, out: Uint8Array | number[]) => void; legend: Legend }

export const titles: Record<Colouring, { name: string; title: string; unit: string; key: string }> = {
  feed: { name: 'Feed', title: 'Feed of the tip', unit: 'mm/min', key: '1' },
  cause: { name: 'Limit', title: 'What limits the feed', unit: '', key: '2' },
  deviation: { name: 'Deviation', title: 'Distance from the programmed path', unit: 'µm', key: '3' },
  contact: { name: 'Contact', title: 'Feed at the contact point', unit: 'mm/min', key: '4' },
  turn: { name: 'Tilt rate', title: 'How fast the tool axis turns', unit: '°/s', key: '5' },
  neighbour: { name: 'Neighbours', title: 'Feed against the neighbouring pass: marks', unit: '%', key: '6' }
}

/** The value below which `share` of the cutting places lie; of a sample where there are many. */
function quantile(values: Float32Array, rapid: Uint8Array, share: number): number {
  const stride = Math.max(1, Math.floor(values.length / 20000)), known: number[] = []
  for (let i = 0; i < values.length; i += stride) if (!rapid[i] && Number.isFinite(values[i])) known.push(values[i])
  known.sort((a, b) => a - b)
  return known.length ? known[Math.min(known.length - 1, Math.floor(share * known.length))] : 0
}

/** A round number not below x. */
export function roundUp(x: number): number {
  if (!(x > 0)) return 1
  const power = 10 ** Math.floor(Math.log10(x))
  return [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].map(f => f * power).find(f => f >= x * (1 - 1e-6)) ?? x
}

const rapidColour = (dark: boolean): Rgb => rgbOf(dark ? '#76808d' : '#a8b0ba')

export function paint(run: Run, colouring: Colouring, axes: AxisContent[], dark: boolean): Painted {
  const rapid = run.path.rapid, grey = rapidColour(dark), { title, unit } = titles[colouring]
  const write = (rgb: Rgb, out: Uint8Array | number[]) => { for (let c = 0; c < 3; ++c) out[c] = rgb[c] }
  if (colouring === 'cause') {
    const colours = run.content.causes.map(cause => rgbOf(causeColour(cause, axes, dark)))
    const time = run.timeByCause(), byColour = new Map<string, { name: string; colour: string; time: number }>()
    run.content.causes.forEach((cause, k) => {
      const axis = axes.find(a => cause.startsWith(a.letter + ' '))?.letter, name = axis ? `axis ${axis}` : cause
      const one = byColour.get(name) ?? { name, colour: cssOf(colours[k]), time: 0 }
      one.time += time[k]
      byColour.set(name, one)
    })
    const total = time.reduce((a, b) => a + b, 0) || 1
    const kinds = [...byColour.values()].filter(k => k.time > 0).sort((a, b) => b.time - a.time).slice(0, 8)
    return {
      colour: (i, out) => write(rapid[i] ? grey : colours[run.path.cause[i]] ?? grey, out),
      legend: { title, unit, kinds: kinds.map(k => ({ name: `${k.name} ${(100 * k.time / total).toFixed(0)} %`, colour: k.colour })) }
    }
  }
  const values = run.onPath(colouring), isFeed = colouring === 'feed' || colouring === 'contact'
  const top = roundUp(quantile(values, rapid, isFeed ? 0.995 : 0.98))
  const map = isFeed ? feedColour : amountColour
  const table = Array.from({ length: 256 }, (_, k) => map(k / 255, dark))
  return {
    colour: (i, out) => {
      const value = values[i]
      write(rapid[i] || !Number.isFinite(value) ? grey : table[Math.min(255, Math.max(0, Math.round(value / top * 255)))], out)
    },
    legend: {
      title, unit, ramp: Array.from({ length: 12 }, (_, k) => cssOf(map(k / 11, dark))),
      ticks: [0, 0.25, 0.5, 0.75, 1].map(f => short(f * top) + (f === 1 ? ' …' : ''))
    }
  }
}
