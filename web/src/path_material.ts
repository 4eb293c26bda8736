// Tool paths as flat strips of a given width in pixels, and as ruled ribbons between tip and a height on the tool: both from
// two vertices a place, so that they share their positions and colours.
import { BufferAttribute, BufferGeometry, DoubleSide, DynamicDrawUsage, Group, LineSegments, Mesh, ShaderMaterial, Vector2 } from 'three'

const common = /* glsl */`
  attribute vec3 colour;
  varying vec3 vColour;
`
const stripVertex = common + /* glsl */`
  attribute vec3 before, after;
  attribute float side;
  uniform vec2 resolution;
  uniform float width;
  vec2 onScreen(vec4 p) { return p.xy / p.w * resolution; }
  void main() {
    mat4 m = projectionMatrix * modelViewMatrix;
    vec4 here = m * vec4(position, 1.0);
    vec2 at = onScreen(here), come = at - onScreen(m * vec4(before, 1.0)), go = onScreen(m * vec4(after, 1.0)) - at;
    vec2 along = (dot(come, come) > 1e-8 ? normalize(come) : vec2(0.0)) + (dot(go, go) > 1e-8 ? normalize(go) : vec2(0.0));
    vec2 across = dot(along, along) > 1e-8 ? normalize(vec2(-along.y, along.x)) : vec2(0.0, 1.0);
    here.xy += across * side * width / resolution * here.w;
    here.z -= 1e-5 * here.w;
    gl_Position = here;
    vColour = colour;
  }
`
const ribbonVertex = common + /* glsl */`
  attribute vec3 axis;
  attribute float side;
  uniform float height;
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position + max(side, 0.0) * height * axis, 1.0);
    vColour = colour;
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

/** Steps from place to place as triangles; every `stride`-th place and the ends of stretches. */
function bands(count: number, apart: (i: number) => boolean, stride: number): Parts {
  const index = new Uint32Array(6 * count), ends = new Uint32Array(count)
  let from = 0, n = 0
  for (let i = 1; i < count; ++i) {
    if (apart(i)) { from = i; continue }
    if (i - from < stride && i + 1 < count && !apart(i + 1)) continue
    index.set([2 * from, 2 * from + 1, 2 * i, 2 * from + 1, 2 * i + 1, 2 * i], 6 * n)
    ends[n++] = i
    from = i
  }
  return { size: 6, index: index.slice(0, 6 * n), ends: ends.slice(0, n) }
}

/** Lines across, from one vertex of a place to the other, at every `stride`-th place. */
function rulings(count: number, apart: (i: number) => boolean, stride: number): Parts {
  const index: number[] = [], ends: number[] = []
  for (let i = 0; i < count; i += stride) {
    if (apart(i)) continue
    index.push(2 * i, 2 * i + 1)
    ends.push(i)
  }
  return { size: 2, index: Uint32Array.from(index), ends: Uint32Array.from(ends) }
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

/** Steps of the path of one kind: as they are, and as they are drawn while the picture moves slowly. */
class Steps {
  readonly group = new Group()
  private readonly levels: { object: Mesh | LineSegments; parts: Parts }[]

  constructor(geometry: BufferGeometry, shader: ShaderMaterial, levels: Parts[]) {
    this.levels = levels.map(parts => {
      const own = new BufferGeometry()
      for (const [name, attribute] of Object.entries(geometry.attributes)) own.setAttribute(name, attribute)
      own.setIndex(new BufferAttribute(parts.index, 1))
      const object = parts.size === 2 ? new LineSegments(own, shader) : new Mesh(own, shader)
      object.frustumCulled = false
      this.group.add(object)
      return { object, parts }
    })
    this.coarse(false)
  }
  /** Places [from, to[. */
  show(from: number, to: number) {
    for (const { object, parts } of this.levels) {
      const first = firstNotBelow(parts.ends, from + 1), last = firstNotBelow(parts.ends, to)
      object.geometry.setDrawRange(parts.size * first, parts.size * Math.max(0, last - first))
    }
  }
  coarse(wanted: boolean) {
    this.levels.forEach(({ object }, k) => { object.visible = wanted === (k > 0) })
  }
}

/** The drawn path of a run. `tip` in mm about `centre`. */
export class DrawnPath {
  readonly cutting: Steps
  readonly rapids: Steps
  readonly ribbon: Steps
  readonly materials: ShaderMaterial[]
  private readonly colours: BufferAttribute

  constructor(tip: Float32Array, axis: Int16Array, rapid: Uint8Array) {
    const count = rapid.length
    // Three numbers a vertex, two vertices a place, one place more before the first and behind the last.
    const padded = new Float32Array(6 * (count + 2))
    for (let i = -1; i <= count; ++i) {
      const k = Math.min(count - 1, Math.max(0, i))
      for (let v = 0; v < 2; ++v) for (let c = 0; c < 3; ++c) padded[6 * (i + 1) + 3 * v + c] = tip[3 * k + c]
    }
    const geometry = new BufferGeometry()
    const view = (place: number) => new BufferAttribute(padded.subarray(6 * place, 6 * (place + count)), 3)
    geometry.setAttribute('position', view(1))
    geometry.setAttribute('before', view(0))
    geometry.setAttribute('after', view(2))
    const doubled = new Int16Array(6 * count), side = new Int8Array(2 * count)
    for (let i = 0; i < count; ++i) {
      for (let v = 0; v < 2; ++v) for (let c = 0; c < 3; ++c) doubled[6 * i + 3 * v + c] = axis[3 * i + c]
      side[2 * i] = 1
      side[2 * i + 1] = -1
    }
    geometry.setAttribute('axis', new BufferAttribute(doubled, 3, true))
    geometry.setAttribute('side', new BufferAttribute(side, 1))
    this.colours = new BufferAttribute(new Uint8Array(6 * count), 3, true)
    this.colours.setUsage(DynamicDrawUsage)
    geometry.setAttribute('colour', this.colours)

    const strip = material(stripVertex, 1), faint = material(stripVertex, 0.55), ruled = material(ribbonVertex, 0.5)
    faint.uniforms.width.value = 1
    this.materials = [strip, faint, ruled]
    const coarse = Math.max(1, Math.ceil(count / 12000))
    const isRapid = (i: number) => rapid[i] !== 0, isCut = (i: number) => rapid[i] === 0
    this.cutting = new Steps(geometry, strip, [bands(count, isRapid, 1), bands(count, isRapid, coarse)])
    this.rapids = new Steps(geometry, faint, [bands(count, isCut, 1), bands(count, isCut, coarse)])
    this.ribbon = new Steps(geometry, ruled, [bands(count, isRapid, Math.max(1, Math.ceil(count / 20000))), rulings(count, isRapid, Math.max(1, Math.ceil(count / 1500)))])
  }
  get steps() { return [this.cutting, this.rapids, this.ribbon] }

  /** `colour(i)` writes red, green and blue of place i, 0 … 255. */
  paint(colour: (i: number, out: Uint8Array | number[]) => void) {
    const all = this.colours.array as Uint8Array, one = [0, 0, 0]
    for (let i = 0; i < all.length / 6; ++i) {
      colour(i, one)
      for (let c = 0; c < 3; ++c) all[6 * i + c] = all[6 * i + 3 + c] = one[c]
    }
    this.colours.needsUpdate = true
  }
  resize(width: number, height: number, pixel: number) {
    for (const one of this.materials) one.uniforms.resolution.value.set(width / 2, height / 2)
    this.materials[0].uniforms.width.value = 1.25 * pixel
    this.materials[1].uniforms.width.value = 0.6 * pixel
  }
}
