// Tool paths as flat strips of a given width in pixels, and as ruled ribbons between tip and a height on the tool: both from
// two vertices a place, so that they share their positions and colours. Each is there twice: as it is, and of as few places as a
// browser that draws by software can turn.
import {
  Box3, BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Group, InterleavedBuffer, InterleavedBufferAttribute, LineSegments, Mesh, ShaderMaterial, Sphere, Vector2
} from 'three'

const common = /* glsl */`
  attribute vec4 colour;  // its last part: which of the two vertices, 0 or 1
  varying vec3 vColour;
`
const stripVertex = common + /* glsl */`
  attribute vec3 before, after;
  uniform vec2 resolution;
  uniform float width;
  vec2 onScreen(vec4 p) { return p.xy / p.w * resolution; }
  void main() {
    mat4 m = projectionMatrix * modelViewMatrix;
    vec4 here = m * vec4(position, 1.0);
    vec2 at = onScreen(here), come = at - onScreen(m * vec4(before, 1.0)), go = onScreen(m * vec4(after, 1.0)) - at;
    vec2 along = (dot(come, come) > 1e-8 ? normalize(come) : vec2(0.0)) + (dot(go, go) > 1e-8 ? normalize(go) : vec2(0.0));
    vec2 across = dot(along, along) > 1e-8 ? normalize(vec2(-along.y, along.x)) : vec2(0.0, 1.0);
    here.xy += across * (2.0 * colour.a - 1.0) * width / resolution * here.w;
    here.z -= 1e-5 * here.w;
    gl_Position = here;
    vColour = colour.rgb;
  }
`
const ribbonVertex = common + /* glsl */`
  attribute vec3 axis;
  uniform float height;
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position + colour.a * height * axis, 1.0);
    vColour = colour.rgb;
  }
`
const fragment = /* glsl */`
  varying vec3 vColour;
  uniform float opacity;
  void main() { gl_FragColor = vec4(vColour, opacity); }
`

const material = (vertexShader: string, opacity: number) => new ShaderMaterial({
  vertexShader, fragmentShader: fragment, side: DoubleSide, transparent: opacity < 1, depthWrite: opacity === 1,
  uniforms: { resolution: { value: new Vector2(1, 1) }, width: { value: 2 }, height: { value: 30 }, opacity: { value: opacity } }
})

/** Index of a geometry in parts of `size`, one for each of some places of the path, ascending. */
interface Parts { size: number; index: Uint32Array; ends: Uint32Array }

/** Every `stride`-th place, and both sides of every end of a rapid. */
function every(stride: number, rapid: Uint8Array): Uint32Array {
  const chosen = new Uint32Array(rapid.length), last = rapid.length - 1
  let n = 0
  for (let i = 0; i <= last; ++i)
    if (i % stride === 0 || i === last || rapid[i] !== rapid[i - 1] || rapid[i] !== rapid[i + 1]) chosen[n++] = i
  return chosen.subarray(0, n)
}

/** Steps between the places chosen as triangles; a step is as the place where it ends. */
function bands(chosen: ArrayLike<number>, apart: (i: number) => boolean): Parts {
  const index = new Uint32Array(6 * chosen.length), ends = new Uint32Array(chosen.length)
  let n = 0
  for (let k = 1; k < chosen.length; ++k) {
    const from = 2 * chosen[k - 1], to = 2 * chosen[k]
    if (apart(chosen[k])) continue
    index[6 * n] = from
    index[6 * n + 1] = index[6 * n + 3] = from + 1
    index[6 * n + 2] = index[6 * n + 5] = to
    index[6 * n + 4] = to + 1
    ends[n++] = chosen[k]
  }
  return { size: 6, index: index.subarray(0, 6 * n), ends: ends.subarray(0, n) }
}

/** Lines across, from one vertex of a place to the other. */
function rulings(chosen: ArrayLike<number>, apart: (i: number) => boolean): Parts {
  const ends = Uint32Array.from(chosen).filter(i => !apart(i)), index = new Uint32Array(2 * ends.length)
  ends.forEach((i, k) => { index[2 * k] = 2 * i; index[2 * k + 1] = 2 * i + 1 })
  return { size: 2, index, ends }
}

/** Every so many that some `most` are left. */
const fewer = (chosen: ArrayLike<number>, most: number) => {
  const stride = Math.max(1, Math.ceil(chosen.length / most))
  return Uint32Array.from({ length: Math.ceil(chosen.length / stride) }, (_, k) => chosen[k * stride])
}

function firstNotBelow(values: Uint32Array, x: number): number {
  let low = 0, high = values.length
  while (low < high) {
    const middle = (low + high) >> 1
    if (values[middle] < x) low = middle + 1
    else high = middle
  }
  return low
}

/** Steps of the path of one kind: as they are drawn while the picture moves slowly, and, once made, as they are. */
class Steps {
  readonly group = new Group()
  private readonly levels: { object: Mesh | LineSegments; parts: Parts }[] = []
  private shown: [number, number] = [0, Infinity]

  constructor(private readonly geometry: BufferGeometry, private readonly shader: ShaderMaterial) {}

  /** The coarse one first. */
  add(parts: Parts) {
    const own = new BufferGeometry()
    for (const [name, attribute] of Object.entries(this.geometry.attributes)) own.setAttribute(name, attribute)
    own.boundingSphere = this.geometry.boundingSphere
    own.setIndex(new BufferAttribute(parts.index, 1))
    const object = parts.size === 2 ? new LineSegments(own, this.shader) : new Mesh(own, this.shader)
    object.frustumCulled = false
    this.levels.push({ object, parts })
    this.group.add(object)
    this.show(...this.shown)
  }
  /** Places [from, to[. */
  show(from: number, to: number) {
    this.shown = [from, to]
    for (const { object, parts } of this.levels) {
      const first = firstNotBelow(parts.ends, from + 1), last = firstNotBelow(parts.ends, to)
      object.geometry.setDrawRange(parts.size * first, parts.size * Math.max(0, last - first))
    }
  }
  coarse(wanted: boolean) {
    const seen = wanted ? 0 : this.levels.length - 1
    this.levels.forEach(({ object }, k) => { object.visible = k === seen })
  }
}

/** Places of the path: three numbers a vertex, two vertices a place, and the places before and behind each in the same bytes. */
function placesOf(tip: Float32Array, count: number): BufferGeometry {
  const padded = new Float32Array(6 * (count + 2))
  for (let i = -1; i <= count; ++i) {
    const k = 3 * Math.min(count - 1, Math.max(0, i)), at = 6 * (i + 1)
    padded[at] = padded[at + 3] = tip[k]
    padded[at + 1] = padded[at + 4] = tip[k + 1]
    padded[at + 2] = padded[at + 5] = tip[k + 2]
  }
  const geometry = new BufferGeometry(), bytes = new InterleavedBuffer(padded, 3)
  for (const [place, name] of ['before', 'position', 'after'].entries()) geometry.setAttribute(name, new InterleavedBufferAttribute(bytes, 3, 6 * place))
  geometry.boundingSphere = new Box3().setFromArray(padded).getBoundingSphere(new Sphere())
  return geometry
}

const strip = () => ({ cutting: material(stripVertex, 1), rapids: material(stripVertex, 0.55) })

/** Something with each shader of the path, so that a browser can make them ready before there is a path. */
export function shadersOfPath(): Group {
  const group = new Group()
  for (const shader of Object.values(strip())) group.add(new Mesh(new BufferGeometry(), shader))
  return group
}

/** The drawn path of a run, at first coarse. */
export class DrawnPath {
  readonly cutting: Steps
  readonly rapids: Steps
  readonly ribbon: Steps
  readonly materials: ShaderMaterial[]
  private readonly geometry: BufferGeometry
  private readonly colours: BufferAttribute
  private readonly isRapid = (i: number) => this.path.rapid[i] !== 0
  private readonly isCut = (i: number) => this.path.rapid[i] === 0

  constructor(private readonly path: { tip: Float32Array; axis: Int16Array; rapid: Uint8Array; coarse: Int32Array }) {
    const count = path.rapid.length, { cutting, rapids } = strip(), ruled = material(ribbonVertex, 0.5)
    this.geometry = placesOf(path.tip, count)
    const colours = new Uint8Array(8 * count)
    for (let i = 0; i < count; ++i) colours[8 * i + 3] = 255
    this.colours = new BufferAttribute(colours, 4, true)
    this.colours.setUsage(DynamicDrawUsage)
    this.geometry.setAttribute('colour', this.colours)
    rapids.uniforms.width.value = 1
    this.materials = [cutting, rapids, ruled]
    this.cutting = new Steps(this.geometry, cutting)
    this.rapids = new Steps(this.geometry, rapids)
    this.ribbon = new Steps(this.geometry, ruled)
    this.cutting.add(bands(path.coarse, this.isRapid))
    this.rapids.add(bands(path.coarse, this.isCut))
  }
  get steps() { return [this.cutting, this.rapids, this.ribbon] }

  /** All places. */
  refine() {
    const places = every(1, this.path.rapid)
    this.cutting.add(bands(places, this.isRapid))
    this.rapids.add(bands(places, this.isCut))
  }

  private ruled = false
  /** The ribbon is made when it is first wanted: true. */
  rule(): boolean {
    if (this.ruled) return false
    this.ruled = true
    const { axis, rapid, coarse } = this.path, count = rapid.length, doubled = new Int16Array(8 * count)
    for (let i = 0; i < count; ++i)
      for (let c = 0; c < 3; ++c) doubled[8 * i + c] = doubled[8 * i + 4 + c] = axis[3 * i + c]
    this.geometry.setAttribute('axis', new BufferAttribute(doubled, 4, true))
    this.ribbon.add(rulings(fewer(coarse, 800), this.isRapid))
    this.ribbon.add(bands(every(Math.ceil(count / 20000), rapid), this.isRapid))
    return true
  }

  /** `colour(i)` writes red, green and blue of place i, 0 … 255. */
  paint(colour: (i: number, out: Uint8Array | number[]) => void) {
    const bytes = this.colours.array as Uint8Array, one = [0, 0, 0]
    for (let i = 0; i < bytes.length / 8; ++i) {
      colour(i, one)
      for (let c = 0; c < 3; ++c) bytes[8 * i + c] = bytes[8 * i + 4 + c] = one[c]
    }
    this.colours.needsUpdate = true
  }
  resize(width: number, height: number, pixel: number) {
    for (const one of this.materials) one.uniforms.resolution.value.set(width / 2, height / 2)
    this.materials[0].uniforms.width.value = 1.25 * pixel
    this.materials[1].uniforms.width.value = 0.6 * pixel
  }
}
