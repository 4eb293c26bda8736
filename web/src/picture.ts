// The picture: tool path, ruled ribbon, tool and machine, in the frame of the part or of the machine. Drawn on demand.
import { AxesHelper, Box3, Color, Group, Matrix4, PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer } from 'three'
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js'
import { paint, titles, type Legend } from './colouring'
import { pause } from './content'
import { element, short } from './element'
import { MachineModel, type Used } from './machine_model'
import { DrawnPath, shadersOfPath } from './path_material'
import type { State } from './state'
import type { Run } from './run'
import type { ProgramText } from './program_text'
import { ToolModel } from './tool_model'

/** Milliseconds a frame may take before the moving picture is drawn with fewer places. */
const slowFrame_ms = 28
const reach_px = 14

interface Drawn { path: DrawnPath; run: Run }

/** Null where the browser has no WebGL. The ground hides what is behind it, and steps of the path are as narrow as their edges
 *  would be: neither an alpha channel nor smooth edges, which a browser without a graphics card pays for in every picture. */
export function openRenderer(): WebGLRenderer | null {
  const canvas = document.createElement('canvas')
  const context = canvas.getContext('webgl2', { alpha: false, antialias: false, stencil: false, powerPreference: 'high-performance' })
  if (!context) return null
  const renderer = new WebGLRenderer({ canvas, context })
  // Asking for errors waits for the compiler of shaders.
  renderer.debug.checkShaderErrors = false
  renderer.setPixelRatio(Math.min(devicePixelRatio, 1.5))
  // The compiler works while the page unpacks its columns.
  const scene = new Scene(), tool = new ToolModel()
  tool.show(undefined, 1)
  scene.add(shadersOfPath(), tool.group, new AxesHelper(1))
  renderer.compile(scene, new PerspectiveCamera())
  return renderer
}

/** Until what was asked of the graphics stands. Whatever waits for them in one go blocks all of the page. */
async function drawn(renderer: WebGLRenderer) {
  const gl = renderer.getContext() as WebGL2RenderingContext, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0)
  if (!fence) return
  gl.flush()
  while (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise(resolve => setTimeout(resolve, 4))
  gl.deleteSync(fence)
}

function bounds(run: Run): Box3 {
  const box = new Box3(), tip = run.path.tip, point = new Vector3()
  const rapids = !run.path.rapid.includes(0)
  for (let i = 0; i < run.path.count; ++i)
    if (rapids || !run.path.rapid[i]) box.expandByPoint(point.fromArray(tip, 3 * i))
  return box.isEmpty() ? new Box3(new Vector3(-10, -10, -10), new Vector3(10, 10, 10)) : box
}

/** Middle of what each linear axis does, of an upright one the top. */
function usedOfAxes(state: State): Record<string, Used> {
  const out: Record<string, Used> = {}
  for (const axis of state.content.machine.axes) {
    const { least, greatest } = state.runs[0].axis(axis.letter, 'position')
    let low = Infinity, high = -Infinity
    for (let i = 0; i < least.length; ++i) { low = Math.min(low, least[i]); high = Math.max(high, greatest[i]) }
    const upright = axis.direction[2] * (axis.reversed ? -1 : 1)
    out[axis.letter] = low > high ? { usual: 0, travel: 0 } : { usual: upright > 0.7 ? high : upright < -0.7 ? low : (low + high) / 2, travel: high - low }
  }
  return out
}

export class Picture {
  readonly root = element('section', { class: 'picture', 'aria-label': 'Tool path' })
  private readonly scene = new Scene()
  private readonly camera = new PerspectiveCamera(32, 1, 0.1, 1e5)
  private readonly controls: OrbitControls
  private readonly part = new Group()
  private readonly tool = new ToolModel()
  private readonly machine: MachineModel
  private readonly box: Box3
  private readonly size: number
  private readonly tip = element('div', { class: 'hover', role: 'status', hidden: true })
  private readonly legend = element('div', { class: 'legend' })
  private drawn = new Map<number, Drawn>()
  private wanted = false
  private moving = 0
  private coarse = false
  private drawnAt = 0
  private settling = 0
  private hoverAt: [number, number] | null = null
  /** When the first picture stands. */
  readonly ready: Promise<void>
  private compiled = false

  constructor(private readonly state: State, private readonly text: ProgramText, private readonly renderer: WebGLRenderer) {
    this.box = bounds(state.runs[0])
    this.size = Math.max(1, this.box.getSize(new Vector3()).length())
    const tool = state.runs[0].content.tools[0] ?? { length_mm: 0, diameter_mm: 0 }
    const low = this.box.min.z + state.content.setup.origin_mm[2]
    this.machine = new MachineModel(state.content.machine, state.content.setup, this.size / 2, low, tool, usedOfAxes(state))
    this.scene.add(this.part)
    this.part.matrixAutoUpdate = false
    this.part.add(this.tool.group)
    const corner = new AxesHelper(this.size * 0.09)
    corner.position.copy(this.box.min).addScaledVector(new Vector3(1, 1, 1), -0.04 * this.size)
    this.part.add(corner)
    this.camera.up.set(0, 0, 1)
    this.controls = new OrbitControls(this.camera, this.renderer.domElement)
    this.controls.addEventListener('change', () => this.stir())
    this.renderer.domElement.tabIndex = 0
    this.renderer.domElement.setAttribute('aria-label', 'Picture of the tool path; drag to turn, wheel to zoom, right button to shift')
    this.root.append(this.renderer.domElement, this.legend, this.tip)

    state.on(['colouring', 'dark'], () => this.paintAll())
    state.on(['run', 'ribbon'], () => this.showRun())
    state.on(['window'], () => this.showWindow())
    state.on(['cursor_s', 'run'], () => this.moveTool())
    state.on(['frame'], () => { this.moveTool(); this.fit() })
    state.on(['height_mm'], () => this.setHeight())
    this.watchPointer()
    new ResizeObserver(() => this.resize()).observe(this.root)
    this.showRun()
    this.moveTool()
    this.resize()
    this.fit()
    this.ready = this.prepare()
  }

  /** Draws when the shaders of all that is to be seen are there. */
  private async prepare() {
    this.compiled = false
    const aside = this.renderer.getContext().getExtension('KHR_parallel_shader_compile')
    await (aside ? this.renderer.compileAsync(this.scene, this.camera) : pause())
    await drawn(this.renderer)
    this.compiled = true
    this.drawNow()
    await drawn(this.renderer)
  }

  /** From the first picture, which is coarse, to all places. */
  async refine() {
    for (const { path } of this.drawn.values()) path.refine()
    this.refined = true
    this.draw()
    await drawn(this.renderer)
  }
  private refined = false

  /** All of the path, seen from above and the front. */
  fit() {
    const shown = this.box.clone()
    if (this.state.get('frame') === 'machine') shown.applyMatrix4(this.part.matrix).union(new Box3().setFromObject(this.machine.group))
    const target = shown.getCenter(new Vector3()), radius = shown.getSize(new Vector3()).length() / 2
    const narrower = Math.min(1, this.camera.aspect), distance = 0.9 * radius / Math.sin(this.camera.fov / 2 * Math.PI / 180) / narrower
    this.controls.target.copy(target)
    this.camera.position.copy(target).addScaledVector(new Vector3(0.55, -0.95, 0.72).normalize(), distance)
    this.camera.near = this.size / 500
    this.camera.far = this.size * 60
    this.camera.updateProjectionMatrix()
    this.controls.update()
    this.draw()
  }

  /** About the target, by angles in degrees: to the side and up. */
  turn(side: number, up: number) {
    const from = this.camera.position.clone().sub(this.controls.target), radius = from.length()
    const azimuth = Math.atan2(from.y, from.x) + side * Math.PI / 180
    const height = Math.min(1.55, Math.max(-1.55, Math.asin(from.z / radius) + up * Math.PI / 180))
    from.set(Math.cos(azimuth) * Math.cos(height), Math.sin(azimuth) * Math.cos(height), Math.sin(height)).multiplyScalar(radius)
    this.camera.position.copy(this.controls.target).add(from)
    this.controls.update()
  }

  /** Draws something that goes on to move, maybe. */
  private stir() {
    this.moving = performance.now()
    this.draw()
  }
  draw() {
    if (this.wanted) return
    this.wanted = true
    requestAnimationFrame(() => { this.wanted = false; this.drawNow() })
  }

  drawNow() {
    if (!this.compiled) return
    const moving = performance.now() - this.moving < 200
    for (const { path } of this.drawn.values()) for (const step of path.steps) step.coarse(moving && this.coarse)
    // Software draws aside: only the time from frame to frame tells what one takes.
    const now = performance.now(), between = now - this.drawnAt
    if (moving && between > slowFrame_ms && between < 1000) this.coarse = true
    this.drawnAt = now
    this.renderer.render(this.scene, this.camera)
    clearTimeout(this.settling)
    if (moving && this.coarse) this.settling = setTimeout(() => this.draw(), 230)
  }

  /** The picture as it stands, for paper. */
  image(): string {
    this.moving = 0
    this.drawNow()
    return this.renderer.domElement.toDataURL('image/png')
  }

  private resize() {
    const { clientWidth: width, clientHeight: height } = this.root
    if (!width || !height) return
    this.renderer.setSize(width, height)
    this.camera.aspect = width / height
    this.camera.updateProjectionMatrix()
    const pixel = this.renderer.getPixelRatio()
    for (const { path } of this.drawn.values()) path.resize(width * pixel, height * pixel, pixel)
    this.drawNow()
  }

  /** The run in hand; the others are there once they were looked at. */
  private showRun() {
    const index = this.state.get('run')
    if (!this.drawn.has(index)) {
      const run = this.state.runs[index], path = new DrawnPath(run.path)
      if (this.refined) path.refine()
      for (const step of path.steps) this.part.add(step.group)
      this.drawn.set(index, { path, run })
      this.setHeight()
    }
    if (this.state.get('ribbon') && this.drawn.get(index)!.path.rule()) void this.prepare()
    for (const [k, { path }] of this.drawn) {
      path.cutting.group.visible = path.rapids.group.visible = k === index
      path.ribbon.group.visible = k === index && this.state.get('ribbon')
    }
    this.resize()
    this.paintAll()
    this.showWindow()
  }

  private paintAll() {
    const dark = this.state.get('dark'), { path, run } = this.drawn.get(this.state.get('run'))!
    const { colour, legend } = paint(run, this.state.get('colouring'), this.state.content.machine.axes, dark)
    path.paint(colour)
    this.scene.background = new Color(dark ? '#14181d' : '#f7f8fa')
    this.showLegend(legend)
    this.draw()
  }
  private showLegend(legend: Legend) {
    const children: Node[] = [element('strong', {}, legend.title + (legend.unit ? `, ${legend.unit}` : ''))]
    if (legend.ramp)
      children.push(element('div', { class: 'ramp', style: { background: `linear-gradient(to right, ${legend.ramp.join(', ')})` } }),
        element('div', { class: 'ticks' }, ...legend.ticks!.map(t => element('span', {}, t))))
    if (legend.kinds)
      children.push(element('ul', {}, ...legend.kinds.map(k => element('li', {}, element('i', { style: { background: k.colour } }), k.name))))
    this.legend.replaceChildren(...children)
  }

  private showWindow() {
    const { path, run } = this.drawn.get(this.state.get('run'))!
    const [from, to] = this.state.get('window'), [first, last] = run.placesBetween(from, to)
    for (const step of path.steps) step.show(first, last)
    this.stir()
  }
  private setHeight() {
    for (const { path } of this.drawn.values()) for (const m of path.materials) m.uniforms.height.value = this.state.get('height_mm')
    this.draw()
  }

  private moveTool() {
    const run = this.state.run, time_s = this.state.get('cursor_s'), pose = run.poseAt(time_s)
    this.tool.show(run.toolAt(time_s), this.size)
    this.tool.group.position.set(...pose.tip)
    this.tool.group.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...pose.axis)))
    const inMachine = this.state.get('frame') === 'machine'
    if (inMachine !== this.machine.group.visible || (inMachine && !this.machine.group.parent)) this.showMachine(inMachine)
    if (inMachine) {
      const positions: Record<string, number> = {}
      for (const axis of this.state.content.machine.axes) positions[axis.letter] = run.valueAt(run.axis(axis.letter, 'position'), time_s)
      this.part.matrix.copy(this.machine.move(positions))
    } else this.part.matrix.copy(new Matrix4())
    this.part.matrixWorldNeedsUpdate = true
    this.stir()
  }

  /** The machine joins the scene when it is first wanted. */
  private showMachine(wanted: boolean) {
    this.machine.group.visible = wanted
    if (!wanted || this.machine.group.parent) return
    this.scene.add(this.machine.group)
    void this.prepare()
  }

  private watchPointer() {
    const canvas = this.renderer.domElement
    let pressed: [number, number] | null = null
    canvas.addEventListener('pointermove', event => {
      if (event.buttons) { this.tip.hidden = true; return }
      const waiting = this.hoverAt !== null
      this.hoverAt = [event.offsetX, event.offsetY]
      if (!waiting) requestAnimationFrame(() => { if (this.hoverAt) this.hover(...this.hoverAt); this.hoverAt = null })
    })
    canvas.addEventListener('pointerleave', () => { this.tip.hidden = true; this.hoverAt = null })
    canvas.addEventListener('pointerdown', event => { pressed = [event.offsetX, event.offsetY] })
    canvas.addEventListener('pointerup', event => {
      if (!pressed || Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) > 4) return
      const place = this.nearest(event.offsetX, event.offsetY)
      if (place >= 0) this.state.moveTo(this.state.run.path.time[place])
    })
  }

  /** Place of the path nearest to a point of the screen, within reach; −1: none. */
  nearest(x: number, y: number): number {
    const run = this.state.run, tip = run.path.tip
    this.part.updateMatrixWorld(true)
    this.camera.updateMatrixWorld(true)
    const m = new Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse).multiply(this.part.matrixWorld).elements
    const { clientWidth: width, clientHeight: height } = this.root
    const [first, last] = run.placesBetween(...this.state.get('window'))
    let best = -1, least = reach_px ** 2
    let beforeX = 0, beforeY = 0, seen = false
    for (let i = first; i < last; ++i) {
      const a = tip[3 * i], b = tip[3 * i + 1], c = tip[3 * i + 2]
      const w = m[3] * a + m[7] * b + m[11] * c + m[15]
      const px = ((m[0] * a + m[4] * b + m[8] * c + m[12]) / w * 0.5 + 0.5) * width
      const py = (0.5 - (m[1] * a + m[5] * b + m[9] * c + m[13]) / w * 0.5) * height
      // To the step that ends here, so that long blocks are found between their ends too.
      let dx = px - x, dy = py - y, at = i
      if (seen && !run.path.rapid[i]) {
        const sx = px - beforeX, sy = py - beforeY, square = sx * sx + sy * sy
        const share = square > 0 ? Math.min(1, Math.max(0, ((x - beforeX) * sx + (y - beforeY) * sy) / square)) : 1
        dx = beforeX + share * sx - x
        dy = beforeY + share * sy - y
        if (share < 0.5 && i > 0) at = i - 1
      }
      const distance = dx * dx + dy * dy
      if (w > 0 && distance < least) { least = distance; best = at }
      beforeX = px; beforeY = py; seen = w > 0
    }
    return best
  }

  private hover(x: number, y: number) {
    const place = this.nearest(x, y), run = this.state.run
    this.tip.hidden = place < 0
    if (place < 0) return
    const line = run.path.line[place], value = (name: 'feed' | 'programmed' | 'deviation') => run.onPath(name)[place]
    const colouring = this.state.get('colouring')
    const rows: [string, string][] = [
      ['feed', `${short(value('feed'))} of ${run.path.rapid[place] ? 'rapid' : short(value('programmed'))} mm/min`],
      ['limited by', run.path.rapid[place] ? 'rapid' : run.content.causes[run.path.cause[place]] ?? '–'],
      ['deviation', `${short(value('deviation'))} µm`]
    ]
    if (colouring === 'turn' || colouring === 'neighbour' || colouring === 'contact')
      rows.push([titles[colouring].name.toLowerCase(), `${short(run.onPath(colouring)[place])} ${titles[colouring].unit}`])
    this.tip.replaceChildren(element('b', {}, `line ${line}`), element('code', {}, this.text.lineOf(run, line)),
      ...rows.map(([name, text]) => element('div', {}, element('span', {}, name), text)))
    this.tip.style.left = `${Math.min(x + 14, this.root.clientWidth - 290)}px`
    this.tip.style.top = `${Math.min(y + 14, this.root.clientHeight - 120)}px`
  }
}
