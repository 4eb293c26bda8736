// The tool as a solid of revolution, tip at the origin, axis along +Z, and what holds it.
import { CylinderGeometry, Group, LatheGeometry, Mesh, Vector2 } from 'three'
import { solidMaterial } from './solid_material'
import type { ToolContent } from './content'

/** Radius and height of the outline from the tip on, mm. `length`: of what is drawn. */
export function outline(tool: Pick<ToolContent, 'kind' | 'diameter_mm' | 'corner_radius_mm'>, length: number): [number, number][] {
  const radius = tool.diameter_mm / 2
  const corner = tool.kind === 'ball' ? radius : tool.kind === 'flat' ? 0 : Math.min(tool.corner_radius_mm, radius)
  const points: [number, number][] = [[0, 0]]
  if (corner === 0) points.push([radius, 0])
  else for (let i = 0; i <= 12; ++i) {
    const angle = i / 12 * Math.PI / 2
    points.push([radius - corner + corner * Math.sin(angle), corner * (1 - Math.cos(angle))])
  }
  points.push([tool.kind === 'taper' ? radius * 1.8 : radius, length])
  points.push([0, length])
  return points
}

/** Diameter and length of what is drawn, mm: a tool without a diameter is a thin needle; the holder reaches to the gauge line.
 *  `size`: of the part. */
export function drawnSize(tool: Pick<ToolContent, 'diameter_mm' | 'length_mm'> | undefined, size: number) {
  const diameter = tool && tool.diameter_mm > 0 ? tool.diameter_mm : size / 60, length = Math.max(3.2 * diameter, size * 0.16)
  return { diameter, length, holder: Math.max(1.2 * diameter, (tool?.length_mm ?? 0) - length) }
}

export class ToolModel {
  readonly group = new Group()
  private shown = ''

  /** `size`: of the part, mm. */
  show(tool: ToolContent | undefined, size: number) {
    const key = JSON.stringify(tool ?? null)
    if (key === this.shown) return
    this.shown = key
    this.group.clear()
    const { diameter, length, holder: above } = drawnSize(tool, size)
    const described = tool && tool.diameter_mm > 0 ? tool : { kind: 'ball' as const, diameter_mm: diameter, corner_radius_mm: 0 }
    const body = new LatheGeometry(outline(described, length).map(([r, z]) => new Vector2(r, z)), 36)
    body.rotateX(Math.PI / 2)
    const holder = new CylinderGeometry(1.05 * diameter, 0.8 * diameter, above, 36)
    holder.rotateX(Math.PI / 2)
    holder.translate(0, 0, length + above / 2)
    this.group.add(new Mesh(body, solidMaterial(0xd9a441, 0.72)),
      new Mesh(holder, solidMaterial(0x8f99a6, 0.4)))
  }
}
