// Shaders. Spheres and cylinders are drawn as squares that face the eye; what they look like is worked out at each pixel.
const COMMON = `#version 300 es
precision highp float;
precision highp int;
uniform mat4 view, projection;
uniform vec3 low, span;
uniform vec4 clip;
`;

const GRAIN_VERTEX = COMMON + `
layout(location = 0) in vec2 corner;
layout(location = 1) in vec4 state;
layout(location = 2) in float radius;
layout(location = 3) in float other;
uniform float size;
uniform bool first;
out vec3 place;
flat out vec3 centre;
flat out float r;
flat out float value;
void main() {
  r = radius * size;
  value = first ? state.w : other;
  centre = (view * vec4(low + state.xyz * span, 1.0)).xyz;
  float d = length(centre);
  vec3 towards = centre / d;
  vec3 right = normalize(cross(towards, vec3(0.0, 1.0, 0.001)));
  // Rays that touch the sphere cut the plane through its centre here.
  float reach = d > 1.001 * r ? r * d / sqrt(d * d - r * r) : 0.0;
  place = centre + (corner.x * right + corner.y * cross(right, towards)) * reach;
  gl_Position = projection * vec4(place, 1.0);
}`;

const GRAIN_FRAGMENT = COMMON + `
in vec3 place;
flat in vec3 centre;
flat in float r;
flat in float value;
uniform sampler2D scale;
uniform vec2 shown;
uniform float kinds;
out vec4 colour;
void main() {
  vec3 ray = normalize(place);
  float b = dot(ray, centre), root = b * b - dot(centre, centre) + r * r;
  if (root < 0.0) discard;
  root = sqrt(root);
  vec3 p = ray * (b - root), n = (p - centre) / r;
  if (dot(clip.xyz, p) + clip.w > 0.0) {
    float t = -clip.w / dot(clip.xyz, ray);
    if (t < b - root || t > b + root) discard;
    p = ray * t;
    n = clip.xyz;
  }
  float at = kinds > 0.0 ? (floor(value * 65535.0 + 0.5) + 0.5) / 256.0 : (clamp((value - shown.x) / (shown.y - shown.x), 0.0, 1.0) * 255.0 + 0.5) / 256.0;
  vec3 base = texture(scale, vec2(at, 0.5)).rgb;
  vec3 light = normalize(vec3(-0.45, 0.75, 0.65));
  float wrap = 0.5 * dot(n, light) + 0.5;
  float gloss = 0.18 * pow(max(dot(n, normalize(light - ray)), 0.0), 40.0);
  float rim = 0.70 + 0.30 * pow(clamp(-dot(n, ray), 0.0, 1.0), 0.7);
  colour = vec4(base * (0.40 + 0.88 * wrap * wrap) * rim + gloss, 1.0);
  vec4 q = projection * vec4(p, 1.0);
  gl_FragDepth = 0.5 * q.z / q.w + 0.5;
}`;

const CHAIN_VERTEX = COMMON + `
layout(location = 0) in vec2 corner;
layout(location = 1) in vec3 from;
layout(location = 2) in vec3 to;
layout(location = 3) in float force;
uniform float thick;
out vec3 place;
out float off;
flat out vec3 side;
flat out float strength;
flat out float wide;
void main() {
  vec3 a = (view * vec4(low + from * span, 1.0)).xyz, b = (view * vec4(low + to * span, 1.0)).xyz;
  vec3 middle = 0.5 * (a + b), axis = b - a;
  vec3 across = cross(axis, middle);
  side = length(across) > 0.0 ? normalize(across) : vec3(1.0, 0.0, 0.0);
  strength = force;
  wide = thick * (0.05 + 0.6 * force);
  off = corner.x;
  place = mix(a, b, 0.5 * corner.y + 0.5) + side * corner.x * wide;
  gl_Position = projection * vec4(place, 1.0);
}`;

const CHAIN_FRAGMENT = COMMON + `
in vec3 place;
in float off;
flat in vec3 side;
flat in float strength;
flat in float wide;
out vec4 colour;
void main() {
  if (dot(clip.xyz, place) + clip.w > 0.0) discard;
  float up = sqrt(max(1.0 - off * off, 0.0));
  vec3 n = normalize(side * off - normalize(place) * up);
  vec3 base = mix(vec3(0.98, 0.76, 0.32), vec3(0.72, 0.06, 0.12), sqrt(strength));
  float wrap = 0.5 * dot(n, normalize(vec3(-0.45, 0.75, 0.65))) + 0.5;
  colour = vec4(base * (0.4 + 0.75 * wrap * wrap), 1.0);
  vec4 q = projection * vec4(place - normalize(place) * up * wide, 1.0);
  gl_FragDepth = 0.5 * q.z / q.w + 0.5;
}`;

// Walls: triangles and edges, lit from both sides.
const WALL_VERTEX = COMMON + `
layout(location = 0) in vec3 point;
out vec3 place;
void main() {
  place = (view * vec4(point, 1.0)).xyz;
  gl_Position = projection * vec4(place, 1.0);
}`;

const WALL_FRAGMENT = COMMON + `
in vec3 place;
uniform vec4 paint;
uniform bool lit;
out vec4 colour;
void main() {
  if (dot(clip.xyz, place) + clip.w > 0.0) discard;
  colour = paint;
  if (lit) {
    vec3 n = normalize(cross(dFdx(place), dFdy(place)));
    float facing = abs(dot(n, normalize(place)));
    if (paint.a < 1.0) colour.a *= 1.0 + 1.6 * pow(1.0 - facing, 3.0);
    else {
      float wrap = 0.5 * abs(dot(n, normalize(vec3(-0.45, 0.75, 0.65)))) + 0.5;
      colour.rgb *= 0.4 + 0.7 * wrap * wrap;
    }
  }
}`;

// Eye-dome lighting: what lies behind its neighbours is darker (C. Boucheny, doctoral thesis, Université Joseph Fourier, Grenoble, 2009).
const SCREEN_VERTEX = `#version 300 es
layout(location = 0) in vec2 corner;
out vec2 at;
void main() { at = 0.5 * corner + 0.5; gl_Position = vec4(corner, 0.0, 1.0); }`;

const SCREEN_FRAGMENT = `#version 300 es
precision highp float;
in vec2 at;
uniform sampler2D image, depth;
uniform vec2 pixel, planes;
uniform vec3 paper;
out vec4 colour;
float away(vec2 place) {
  float z = 2.0 * texture(depth, place).r - 1.0;
  return log2(2.0 * planes.x * planes.y / (planes.y + planes.x - z * (planes.y - planes.x)));
}
void main() {
  float raw = texture(depth, at).r, here = away(at), hidden = 0.0;
  for (int k = 0; k < 16; k++) {
    float angle = 0.785398 * float(k), reach = k < 8 ? 1.6 : 4.5;
    hidden += max(0.0, here - away(at + reach * pixel * vec2(cos(angle), sin(angle)))) / 16.0;
  }
  gl_FragDepth = raw;
  float shade = exp(-min(hidden, 0.02) * 30.0);
  colour = raw >= 1.0 ? vec4(paper, 1.0) : vec4(texture(image, at).rgb * shade, 1.0);
}`;
