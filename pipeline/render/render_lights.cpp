#include "pipeline/render/render_lights.h"

#include "pipeline/config.h"
#include "pipeline/contains.h"
#include "pipeline/render/word_list.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
/// Irradiance (over pi) of power 1: about the key light's.
constexpr float kUsualPower = 0.85f;
/// Of a placed light from what it shines at, in diagonals: its square is a float's.
constexpr double kFarthest = 1e9;

/// Two unit vectors across a direction, the first one level.
void axes_across(const Vec3d& toward, const Vec3d& up, Vec3d& u, Vec3d& v) {
    u = cross(up, toward);
    if (!(length(u) > 1e-6)) u = cross(Vec3d{up.y, up.z, up.x}, toward);
    u = normalized(u);
    v = cross(toward, u);
}

/// What all lights take: brightness, colour, shadows.
void read_common(WordList& words, LightSource& light, const Vec3f& color) {
    const auto power = static_cast<float>(words.number("power", 1, 0, 1e6));
    light.color = words.color("color", color) * power;
    light.shadows = words.on_off("shadows", light.shadows);
}

void read_samples(WordList& words, LightSource& light) {
    light.samples = static_cast<int>(words.number("samples", light.samples, 1, 4096));
}

/// A directional light may be as wide as the sun, or wider.
void read_angle(WordList& words, const LightSetting& setting, LightSource& light) {
    const double angle = words.number("angle", 0, 0, 90);
    read_samples(words, light);
    if (!(angle > 0)) return;
    const double radius = std::tan(0.5 * angle * kRadPerDeg);
    axes_across(light.toward, setting.up, light.u_axis, light.v_axis);
    light.u_axis = light.u_axis * radius, light.v_axis = light.v_axis * radius;
}

LightSource read_studio(WordList& words, const LightSetting& setting) {
    LightSource light =
        words.kind() == "key" ? studio_key(setting.view) : studio_fill(setting.view);
    const Vec3f own = light.color;
    const bool colored = words.has("color");
    read_common(words, light, {1, 1, 1});
    const float strength = std::max({own.x, own.y, own.z});
    light.color = colored
                      ? light.color * strength
                      : Vec3f{light.color.x * own.x, light.color.y * own.y, light.color.z * own.z};
    read_angle(words, setting, light);
    return light;
}

Vec3d sun_direction(WordList& words, const LightSetting& setting) {
    if (words.has("from")) {
        const Vec3d from = normalized(words.vector("from", {}));
        if (!(length(from) > 0)) words.fail("from: expected a direction, found 0,0,0");
        return from;
    }
    // Where the front view looks (named_camera).
    const Vec3d north = setting.up.z != 0 ? Vec3d{0, 1, 0} : Vec3d{0, 0, -1};
    const Vec3d east = cross(north, setting.up);
    const double azimuth = words.number("azimuth", 315, -360, 360) * kRadPerDeg;
    const double elevation = words.number("elevation", 45, -90, 90) * kRadPerDeg;
    return normalized((north * std::cos(azimuth) + east * std::sin(azimuth)) * std::cos(elevation) +
                      setting.up * std::sin(elevation));
}

LightSource read_sun(WordList& words, const LightSetting& setting) {
    LightSource light;
    light.toward = sun_direction(words, setting);
    read_common(words, light, {1, 1, 1});
    light.color = light.color * kUsualPower;
    read_angle(words, setting, light);
    return light;
}

void read_size(WordList& words, const LightSetting& setting, LightSource& light) {
    const double usual = 0.1 * setting.bounds.diagonal();
    Vec3d u, v;
    axes_across(light.toward, setting.up, u, v);
    double width = usual, height = usual;
    if (light.kind == LightKind::rectangle) {
        const auto size = words.numbers("size", 2, {usual, usual});
        width = size[0], height = size[1];
    } else {
        width = height = words.numbers("size", 1, {usual})[0];
    }
    if (!(width > 0 && height > 0)) words.fail("size: expected more than 0");
    light.u_axis = u * (0.5 * width), light.v_axis = v * (0.5 * height);
    read_samples(words, light);
}

void read_cone(WordList& words, LightSource& light) {
    const double half = 0.5 * words.number("cone", 40, 0.01, 180) * kRadPerDeg;
    const double blur = words.number("blur", 0.2, 0, 1);
    light.cos_cone = std::cos(half), light.cos_core = std::cos(half * (1 - blur));
}

/// How far a lamp without `to` shines at the least: what is outside the box is not nearer to its
/// middle, and of what is inside, in a room, the walls are about as far away.
double least_reference(const Bbox& bounds) {
    const Vec3d e = bounds.extent();
    return 0.5 * std::min({e.x, e.y, e.z});
}

/// Where a light shines and how far its power is measured.
void aim(WordList& words, const LightSetting& setting, LightSource& light) {
    const Vec3d middle = setting.bounds.center() + setting.origin;
    const bool has_target = words.has("to");
    const Vec3d target = words.vector("to", middle) - setting.origin;
    const double distance = length(light.position - target);
    light.reference = distance;
    if (!has_target)
        light.reference = std::max(distance, least_reference(setting.bounds));
    const bool aimed = light.kind != LightKind::point || has_target;
    if (!(light.reference > 0) || (aimed && !(distance > 0)))
        words.fail("expected it to be elsewhere than what it shines at (to)");
    if (!(light.reference < kFarthest * std::max(setting.bounds.diagonal(), 1e-300)))
        words.fail(fmt::format("expected it within {:g} diagonals of the model: a sun shines from "
                               "farther away",
                               kFarthest));
    if (distance > 0) light.toward = normalized(light.position - target);
}

LightSource read_placed(WordList& words, const LightSetting& setting, LightKind kind) {
    LightSource light;
    light.kind = kind;
    if (!words.has("at")) words.fail("expected at=x,y,z");
    light.position = words.vector("at", {}) - setting.origin;
    aim(words, setting, light);
    read_common(words, light, {1, 1, 1});
    light.color = light.color * kUsualPower;
    if (kind == LightKind::spot) read_cone(words, light);
    if (kind == LightKind::rectangle || kind == LightKind::disc) read_size(words, setting, light);
    return light;
}

LightSource read_light(WordList& words, const LightSetting& setting) {
    const std::string& kind = words.kind();
    if (kind == "key" || kind == "fill") return read_studio(words, setting);
    if (kind == "sun") return read_sun(words, setting);
    if (kind == "point") return read_placed(words, setting, LightKind::point);
    if (kind == "spot") return read_placed(words, setting, LightKind::spot);
    if (kind == "rect") return read_placed(words, setting, LightKind::rectangle);
    if (kind == "disc") return read_placed(words, setting, LightKind::disc);
    const std::vector<std::string> kinds{"key", "fill", "sun", "point", "spot", "rect", "disc"};
    words.fail({.expected = fmt::format("a kind of light first ({})", fmt::join(kinds, ", ")),
                .found = "'" + kind + "'",
                .hint = did_you_mean(kind, kinds)});
}

}  // namespace

std::vector<LightSource> parse_lights(const std::string& text, const LightSetting& setting) {
    std::vector<LightSource> lights;
    for (const std::string& description : split_descriptions(text)) {
        WordList words("light", description, true);
        lights.push_back(read_light(words, setting));
        words.finish();
    }
    return lights;
}

void check_lights(const std::string& text) {
    // No one's model: any place a light is given lies in its reach and not in its middle.
    parse_lights(text, {{}, {{-1e12, -1e12, -1e12}, {1.1e12, 1.2e12, 1.3e12}}, {}, {0, 1, 0}});
}

std::vector<Material> parse_materials(const std::string& text) {
    std::vector<Material> materials;
    for (const std::string& description : split_descriptions(text)) {
        WordList words("material", description, false);
        Material m;
        m.of_scan = words.takes("color", "scan");
        m.albedo = m.of_scan ? Vec3f{1, 1, 1} : words.color("color", m.albedo, "scan");
        m.specular = static_cast<float>(words.number("specular", m.specular, 0, 1));
        m.shininess = static_cast<int>(words.number("shininess", m.shininess, 1, 10000));
        m.mirror = static_cast<float>(words.number("mirror", m.mirror, 0, 1));
        if (m.of_scan && m.mirror > 0)
            words.fail(
                "color=scan and mirror: mirror images know no colours of a scan; expected one "
                "of the two");
        words.finish();
        materials.push_back(m);
    }
    if (materials.empty()) materials.push_back({});
    return materials;
}

bool shades_scan_colors(const std::string& text) {
    const std::vector<Material> materials = parse_materials(text);
    return std::any_of(materials.begin(), materials.end(),
                       [](const Material& m) { return m.of_scan; });
}

bool tints_shaded(const RenderConfig& config, const std::vector<std::string>& aovs) {
    return contains(aovs, "shaded") && shades_scan_colors(config.material);
}

bool takes_colors(const RenderConfig& config, const std::vector<std::string>& aovs) {
    return contains(aovs, "color") || tints_shaded(config, aovs);
}

}  // namespace slim
