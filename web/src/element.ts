// Elements whose content is text, never markup.

type Child = Node | string | number | null | undefined | false
type Properties = Record<string, unknown>

/** `on…` are listeners, `class` and everything with a dash or known as an attribute is set as one, the rest as properties. */
export function element<K extends keyof HTMLElementTagNameMap>(tag: K, properties: Properties = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const out = document.createElement(tag)
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === false) continue
    if (name.startsWith('on')) out.addEventListener(name.slice(2), value as EventListener)
    else if (name === 'class' || name === 'role' || name === 'for' || name.includes('-')) out.setAttribute(name, String(value))
    else if (name === 'style') Object.assign(out.style, value)
    else (out as unknown as Properties)[name] = value
  }
  for (const child of children) if (child !== null && child !== undefined && child !== false) out.append(child instanceof Node ? child : String(child))
  return out
}

export function fixed(value: number | null | undefined, digits: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–'
  const text = value.toFixed(digits)
  return Number(text) === 0 ? text.replace('-', '') : text
}
/** About four digits. */
export function short(value: number): string {
  if (!Number.isFinite(value)) return '–'
  const size = Math.abs(value)
  if (size >= 1000) return value.toFixed(0)
  if (size >= 100) return String(+value.toFixed(1))
  if (size >= 1e-6) return String(+value.toPrecision(3))
  return '0'
}
export function seconds(value: number): string {
  if (!(value >= 600)) return `${fixed(value, 3)} s`
  const minutes = Math.floor(value / 60), hours = Math.floor(minutes / 60)
  const rest = `${String(minutes % 60).padStart(hours ? 2 : 1, '0')} min ${(value % 60).toFixed(1)} s`
  return hours ? `${hours} h ${rest}` : rest
}
