// Pillars and a floor around the object, and the composition of the scene by depth.

@group(0) @binding(0) var<uniform> projection_view: mat4x4<f32>;

struct Pillar {
    @builtin(position) position: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) tint: f32,
}

// A cube for each instance: eight pillars in a circle, and the floor.
@vertex
fn pillars_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Pillar {
    let face = vertex / 6u;
    let axis = face / 2u;
    let side = f32(face % 2u) * 2.0 - 1.0;
    let corners = array<vec2<f32>, 6>(vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0));
    let corner = corners[vertex % 6u];
    var place = vec3<f32>();
    var normal = vec3<f32>();
    place[axis] = side;
    normal[axis] = side;
    place[(axis + 1u) % 3u] = corner.x;
    place[(axis + 2u) % 3u] = corner.y;
    let angle = 0.785398 * f32(instance);
    let is_floor = instance == 8u;
    let size = select(vec3(0.09, 0.75, 0.09), vec3(2.0, 0.05, 2.0), is_floor);
    let middle = select(vec3(1.25 * cos(angle), -0.05, 1.25 * sin(angle)), vec3(0.0, -0.85, 0.0), is_floor);
    return Pillar(projection_view * vec4(middle + size * place, 1.0), normal, select(0.55, 0.22, is_floor));
}

@fragment
fn pillars_fragment(in: Pillar) -> @location(0) vec4<f32> {
    let light = 0.35 + 0.65 * max(dot(in.normal, normalize(vec3(0.4, 0.8, 0.45))), 0.0);
    return vec4(in.tint * light * vec3(0.85, 0.9, 1.0), 1.0);
}

struct Camera {
    projection: mat4x4<f32>,
    view: mat4x4<f32>,      // of object space
}
@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var scene_color: texture_2d<f32>;
@group(0) @binding(2) var scene_depth: texture_2d<f32>;
@group(0) @binding(3) var host_depth: texture_depth_2d;

@vertex
fn compose_vertex(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(vertex << 1u & 2u) * 2.0 - 1.0, f32(vertex & 2u) * 2.0 - 1.0, 0.5, 1.0);
}

// The depth of the scene is that of half its opacity, along the axis of view and in object units; where matter is too thin for
// that, the middle of the object counts.
@fragment
fn compose_fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(position.xy);
    let depth = textureLoad(scene_depth, pixel, 0).r;
    let scale = length(camera.view[0].xyz);
    let z = select(camera.view[3].z, -scale * depth, depth < 1e6);
    let p = camera.projection;
    let projected = (p[2][2] * z + p[3][2]) / (p[2][3] * z + p[3][3]);
    if projected > textureLoad(host_depth, pixel, 0) {
        discard;
    }
    return textureLoad(scene_color, pixel, 0);
}
