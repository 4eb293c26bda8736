// Colours that colour-blind eyes tell apart: viridis and cividis for amounts, Okabe and Ito's for kinds.
import type { AxisContent } from './content'

export type Rgb = [number, number, number]
export const rgbOf = (hex: string): Rgb => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16)) as Rgb
export const cssOf = (c: Rgb) => `rgb(${c.map(Math.round).join(' ')})`

const stops = (text: string) => text.split(' ').map(hex => rgbOf('#' + hex))
const viridis = stops('440154 482475 414487 355f8d 2a788e 21918c 22a884 44bf70 7ad151 bddf26 fde725')
const cividis = stops('00224e 123570 3b496c 575d6d 707173 8a8678 a59c74 c3b369 e1cc55 fee838')

function sample(map: Rgb[], share: number): Rgb {
  const x = Math.min(1, Math.max(0, share)) * (map.length - 1), i = Math.min(map.length - 2, Math.floor(x))
  return [0, 1, 2].map(c => map[i][c] + (map[i + 1][c] - map[i][c]) * (x - i)) as Rgb
}

/** The ends of the maps come too near to the ground of the page, dark or light, to be seen on it. */
const trimmed = (share: number, dark: boolean) => dark ? 0.16 + 0.84 * share : 0.9 * share

/** Slow is what to look at: it stands out of the ground in both themes. */
export const feedColour = (share: number, dark: boolean): Rgb => sample(viridis, trimmed(dark ? 1 - share : share, dark))
/** Much is what to look at. */
export const amountColour = (share: number, dark: boolean): Rgb => sample(cividis, trimmed(dark ? share : 1 - share, dark))

const okabeIto = ['#e69f00', '#56b4e9', '#009e73', '#cc79a7', '#d55e00']
export const otherKind = '#f0e442'

/** By place among the machine's axes. */
export const axisColour = (index: number) => okabeIto[index % okabeIto.length]

/** A cause is `feed`, `A jerk`, `X velocity`, `standstill`, …: it has the colour of its axis. */
export function causeColour(cause: string, axes: AxisContent[], dark: boolean): string {
  if (cause === 'feed') return dark ? '#7d8794' : '#8d96a3'
  if (cause === 'standstill' || cause === 'none' || cause === 'planner' || cause === 'stop') return dark ? '#4d5561' : '#c2c8d0'
  const axis = axes.findIndex(a => cause.startsWith(a.letter + ' '))
  return axis >= 0 ? axisColour(axis) : dark ? otherKind : '#8a7d00'
}
