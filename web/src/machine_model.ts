// The machine as boxes and cylinders, moved by its axes. The chain, read from workpiece to tool, is a product of screws; where the
// machine stands on the floor no machine file says: here it stands between the rotary axes of the table and the linear axes.
import {
  BoxGeometry, type BufferGeometry, CylinderGeometry, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, Quaternion, Vector3
} from 'three'
import { solidMaterial } from './solid_material'
import { drawnSize } from './tool_model'
import type { AxisContent, MachineContent, SetupContent } from './content'

const vector = (v: number[]) => new Vector3(v[0], v[1], v[2])

/** What an axis does at a position, mm or degrees, read from workpiece to tool. */
export function motionOf(axis: AxisContent, position: number): Matrix4 {
  const amount = axis.reversed ? -position : position, direction = vector(axis.direction)
  if (!axis.rotary) return new Matrix4().makeTranslation(direction.multiplyScalar(amount))
  const point = vector(axis.point_mm)
  return new Matrix4().makeTranslation(point)
    .multiply(new Matrix4().makeRotationAxis(direction.normalize(), amount * Math.PI / 180))
    .multiply(new Matrix4().makeTranslation(point.clone().negate()))
}

export function workpieceFrame(setup: SetupContent): Matrix4 {
  const r = setup.rotation, o = setup.origin_mm
  return new Matrix4().set(r[0][0], r[0][1], r[0][2], o[0], r[1][0], r[1][1], r[1][2], o[1], r[2][0], r[2][1], r[2][2], o[2], 0, 0, 0, 1)
}

/** How many axes of the chain, from the workpiece on, carry the table: to the last rotary one with a linear one behind it. */
export function tableAxes(machine: MachineContent): number {
  const chain = machine.chain.map(i => machine.axes[i])
  let count = 0
  chain.forEach((axis, k) => { if (axis.rotary && chain.slice(k + 1).some(a => !a.rotary)) count = k + 1 })
  return count
}

export interface MachinePose {
  /** Workpiece → floor. */
  part: Matrix4
  /** What hangs on each axis of the chain → floor, order of the chain. */
  links: Matrix4[]
}
/** `positions`: by letter, mm or degrees. */
export function poseOf(machine: MachineContent, setup: SetupContent, positions: Record<string, number>): MachinePose {
  const chain = machine.chain.map(i => machine.axes[i]), table = tableAxes(machine)
  const moved = chain.map(axis => motionOf(axis, positions[axis.letter] ?? 0))
  const links: Matrix4[] = new Array(chain.length)
  let sum = new Matrix4()
  for (let k = table - 1; k >= 0; --k) links[k] = (sum = sum.clone().multiply(moved[k].clone().invert()))
  const part = sum.clone().multiply(workpieceFrame(setup))
  sum = new Matrix4()
  for (let k = table; k < chain.length; ++k) links[k] = (sum = sum.clone().multiply(moved[k]))
  return { part, links }
}

const upright = new Vector3(0, 1, 0)  // of three's cylinders

/** Where an axis stands when its slide is to be near the head, and how far it goes. */
export interface Used { usual: number; travel: number }

export class MachineModel {
  readonly group = new Group()
  private readonly links: Group[]
  private clear = false

  /** `reach`: half the size of the part, mm; `low`: its lowest place in the machine with all axes at 0; `used`: what each axis does, by
   *  letter: slides are drawn near the head, and as long as it takes. */
  constructor(private readonly machine: MachineContent, private readonly setup: SetupContent, reach: number, low: number,
              tool: { length_mm: number; diameter_mm: number }, private readonly used: Record<string, Used>) {
    const chain = machine.chain.map(i => machine.axes[i]), table = tableAxes(machine)
    this.links = chain.map(() => new Group())
    this.links.forEach(link => { link.matrixAutoUpdate = false; this.group.add(link) })
    const size = Math.max(reach, 20), drawn = drawnSize(tool, 2 * reach)
    // The nose of the spindle stands at the gauge line, or above the drawn tool where that is longer than the tool's length.
    const nose = Math.max(0, drawn.length + drawn.holder - tool.length_mm), spindle = Math.max(0.2 * size, 0.9 * drawn.diameter)
    const pivots = chain.slice(table).filter(a => a.rotary).map(a => a.point_mm[2])
    const head = { spindle, nose, top: pivots.length ? Math.max(nose + 2 * spindle, ...pivots) : nose + 0.9 * size }
    chain.forEach((axis, k) => {
      this.clear = k >= table
      if (k < table) this.addTableSolid(axis, k, size, low)
      else {
        const beyond = new Vector3()
        for (const other of chain.slice(k + 1)) if (!other.rotary) beyond.applyMatrix4(motionOf(other, used[other.letter].usual))
        this.addToolSideSolid(axis, k, size, head, beyond)
      }
    })
    this.clear = false
    if (table === 0) this.group.add(this.box([2.6 * size, 2.6 * size, 0.16 * size], new Vector3(setup.origin_mm[0], setup.origin_mm[1], low - 0.1 * size), 0x8b95a3))
  }

  /** What carries the part is seen as a body, what carries the tool lets the path be seen behind it. */
  private solid(geometry: BufferGeometry, at: Vector3, colour: number): Mesh {
    const mesh = new Mesh(geometry, solidMaterial(colour, this.clear ? 0.35 : 0.92, !this.clear))
    mesh.add(new LineSegments(new EdgesGeometry(geometry, 30), new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.8 })))
    mesh.position.copy(at)
    return mesh
  }
  private box(size: [number, number, number], at: Vector3, colour: number) { return this.solid(new BoxGeometry(...size), at, colour) }
  private cylinder(radius: number, length: number, direction: Vector3, at: Vector3, colour: number) {
    const mesh = this.solid(new CylinderGeometry(radius, radius, length, 40), at, colour)
    mesh.quaternion.copy(new Quaternion().setFromUnitVectors(upright, direction.clone().normalize()))
    return mesh
  }

  /** A disc that turns about its axis under the part; about a lying axis a cradle with a bearing on each side. */
  private addTableSolid(axis: AxisContent, k: number, size: number, low: number) {
    const direction = vector(axis.direction).normalize(), link = this.links[k]
    if (!axis.rotary) {
      link.add(this.box([2.4 * size, 2.4 * size, 0.14 * size], new Vector3(...axis.point_mm).setZ(low - 0.35 * size), 0x9aa5b4))
      return
    }
    const point = vector(axis.point_mm)
    if (Math.abs(direction.z) > 0.7) {
      const at = point.clone().add(direction.clone().multiplyScalar((low - 0.08 * size - point.z) / direction.z))
      link.add(this.cylinder(1.25 * size, 0.16 * size, direction, at, 0x8793a1))
      return
    }
    const bottom = low - 0.28 * size
    const plate = this.box([3.1 * size, 1.5 * size, 0.18 * size], new Vector3(), 0x7a7391)
    const turned = new Quaternion().setFromUnitVectors(new Vector3(1, 0, 0), direction)
    plate.quaternion.copy(turned)
    plate.position.set(point.x, point.y, bottom)
    link.add(plate)
    for (const end of [-1, 1]) {
      const at = point.clone().add(direction.clone().multiplyScalar(end * 1.5 * size))
      const cheek = this.box([0.14 * size, 0.7 * size, Math.abs(point.z - bottom) + 0.5 * size], at.clone().setZ((point.z + bottom) / 2), 0x7a7391)
      cheek.quaternion.copy(turned)
      link.add(cheek)
      this.group.add(this.cylinder(0.3 * size, 0.3 * size, direction, at.clone().addScaledVector(direction, end * 0.22 * size), 0x66707d))
    }
  }

  /** From the floor to the tool: slides, then the head that the tool hangs in. The gauge point is the origin with all axes at 0;
   *  `beyond` is where the axes between this one and the tool take it. */
  private addToolSideSolid(axis: AxisContent, k: number, size: number, head: { spindle: number; nose: number; top: number }, beyond: Vector3) {
    const link = this.links[k], direction = vector(axis.direction).normalize(), up = new Vector3(0, 0, 1), { spindle, nose, top } = head
    if (axis.rotary) {
      const point = vector(axis.point_mm)
      link.add(this.cylinder(1.5 * spindle, 1.1 * spindle, direction, point.setZ(Math.max(point.z, top - 0.5 * spindle)), 0x7a7391))
    } else {
      const behind = this.machine.chain.slice(k + 1).filter(i => !this.machine.axes[i].rotary).length
      const isRam = Math.abs(direction.z) > 0.7, thick = 0.26 * size, long = this.used[axis.letter].travel + (isRam ? 0.9 : 2.2) * size
      const height = isRam ? top + long / 2 : top + (0.3 + 0.32 * behind) * size
      const bar = this.box([long, thick, thick], new Vector3(0, 0, height).add(beyond), [0x9aa5b4, 0x6f9a8d, 0xb08d57][behind % 3])
      bar.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(1, 0, 0), direction))
      link.add(bar)
    }
    if (k + 1 < this.links.length) return
    link.add(this.cylinder(spindle, top - nose, up, new Vector3(0, 0, (nose + top) / 2), 0x66707d))
    link.add(this.cylinder(0.7 * spindle, 0.16 * size, up, new Vector3(0, 0, nose + 0.06 * size), 0xb0b8c2))
  }

  pose(positions: Record<string, number>) { return poseOf(this.machine, this.setup, positions) }

  /** Moves the solids; returns workpiece → floor. */
  move(positions: Record<string, number>): Matrix4 {
    const pose = this.pose(positions)
    pose.links.forEach((matrix, k) => { this.links[k].matrix.copy(matrix) })
    return pose.part
  }
}
