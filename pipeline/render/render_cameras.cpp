#include "pipeline/render/render_cameras.h"

#include "pipeline/option_names.h"
#include "raytrace/camera_path.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace slim {

std::vector<std::string> keyframes_of(const RenderConfig& config) {
    std::vector<std::string> keys;
    for (std::size_t begin = 0; begin <= config.path.size();) {
        const std::size_t end = std::min(config.path.find(';', begin), config.path.size());
        keys.push_back(config.path.substr(begin, end - begin));
        begin = end + 1;
    }
    return keys;
}

namespace {

/// "iso zoom 2" as a configuration of its own.
RenderConfig keyframe_of(const RenderConfig& config, std::string text) {
    RenderConfig key = config;
    if (const std::size_t at = text.find("zoom"); at != std::string::npos) {
        const std::vector<double> zoom = parse_numbers(text.substr(at + 4));
        if (zoom.size() != 1 || !(zoom[0] > 0))
            throw ConfigError({.key = "path",
                               .expected = "a number > 0 after zoom",
                               .found = "'" + text + "'"});
        key.zoom = zoom[0];
        text.resize(at);
    }
    const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
    if (first == std::string::npos)
        throw ConfigError({.key = "path", .problem = "a keyframe without a camera"});
    key.camera = text.substr(first, last - first + 1);
    return key;
}

std::vector<Camera> path_of(const RenderConfig& config, const ModelHeader& model,
                            const PictureSize& size, const LegendRoom& room) {
    std::vector<Camera> keys;
    for (const std::string& key : keyframes_of(config)) {
        const RenderConfig frame = keyframe_of(config, key);
        try {
            keys.push_back(make_camera(frame, model, size, room));
        } catch (const ConfigError& error) {  // said of --camera, which is not given
            Fault fault = error.fault();
            std::string text = fmt::format("keyframe {} \"{}\"", keys.size() + 1, frame.camera);
            if (fault.key != "camera") text += ": " + quoted_key(fault.key);
            if (!fault.problem.empty()) text += ": " + fault.problem;
            fault.key = "path", fault.problem = text;
            throw ConfigError(fault);
        }
    }
    return keys;
}

}  // namespace

std::vector<std::string> cameras_of(const RenderConfig& config) {
    if (config.path.empty()) return {config.camera};
    std::vector<std::string> cameras;
    for (const std::string& key : keyframes_of(config))
        cameras.push_back(keyframe_of(config, key).camera);
    return cameras;
}

int n_frames(const RenderConfig& config) {
    if (config.turntable > 0 && !config.path.empty())
        throw ConfigError(
            {.key = "turntable",
             .problem = " and " + quoted_key("path") + " both move the camera: give one"});
    if (config.path.empty() != (config.frames == 0))
        throw config.path.empty()
            ? ConfigError({.key = "frames",
                           .problem = " is for a " + quoted_key("path") + ", which is not given"})
            : ConfigError({.key = "path",
                           .problem = "say how many pictures with " + quoted_key("frames")});
    const int n = config.turntable > 0 ? config.turntable : config.path.empty() ? 1 : config.frames;
    const bool film = config.turntable > 0 || !config.path.empty();
    if (config.frame > (film ? n : 0))
        throw film ? ConfigError({.key = "frame",
                                  .expected = fmt::format("1 to {}", n),
                                  .found = std::to_string(config.frame)})
                   : ConfigError({.key = "frame",
                                  .problem = " is for a " + quoted_key("turntable") + " or a " +
                                             quoted_key("path") + ", which are not given"});
    return n;
}

FilmCameras::FilmCameras(const RenderConfig& config, const ModelHeader& model,
                         const PictureSize& size, const LegendRoom& room)
    : frames_(config.frames), turntable_(config.turntable), up_(up_vector(up_axis(config))) {
    if (!config.path.empty()) {
        keys_ = path_of(config, model, size, room);
        return;
    }
    keys_ = {make_camera(config, model, size, room)};
    center_ = is_camera_name(config.camera) && !model.bounds.empty() ? model.bounds.center()
                                                                     : keys_[0].target;
}

Camera FilmCameras::at(int frame) const {
    if (turntable_ > 0) return turned(keys_[0], center_, up_, 360.0 * frame / turntable_);
    const double t = frames_ > 1 ? static_cast<double>(frame) / (frames_ - 1) : 0;
    return frames_ > 0 ? camera_on_path(keys_, t * static_cast<double>(keys_.size() - 1))
                       : keys_[0];
}

}  // namespace slim
