// How tool and machine look: one light from above, one shader that a browser without a graphics card makes ready in no time.
import { Color, ShaderMaterial } from 'three'

const vertex = /* glsl */`
  varying vec3 vNormal;
  void main() {
    vNormal = mat3(modelMatrix) * normal;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }
`
const fragment = /* glsl */`
  varying vec3 vNormal;
  uniform vec3 colour;
  uniform float opacity;
  const vec3 light = vec3(0.379, -0.531, 0.758);
  void main() {
    float bright = 0.48 + 0.7 * max(dot(normalize(vNormal), light), 0.0);
    gl_FragColor = vec4(pow(colour * bright, vec3(1.0 / 2.2)), opacity);
  }
`

export const solidMaterial = (colour: number, opacity: number, hides = true) => new ShaderMaterial({
  vertexShader: vertex, fragmentShader: fragment, transparent: true, depthWrite: hides, uniforms: { colour: { value: new Color(colour) }, opacity: { value: opacity } }
})
