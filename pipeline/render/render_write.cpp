#include "pipeline/render/render_write.h"

#include "pipeline/render/render_antialias.h"
#include "raytrace/crop.h"
#include "raytrace/lines/ink_plane.h"
#include "raytrace/lines/stroke.h"
#include "raytrace/scale_bar.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace slim {
namespace {

void put_background(const RenderJob& job, const std::string& aov, const PixelWindow& at,
                    Picture& picture) {
    if (aov == "environment" && job.config.environment_behind)
        return composite_over_environment(*job.shadings.environment,
                                          pixel_view(job.camera, job.size.width, job.size.height),
                                          at.x, at.y, picture);
    const bool on_white = job.looks.at(aov).on_white() || aov == "lines";
    composite_over(parse_background(job.config.background, on_white), picture, at.y,
                   job.size.height);
}

/// The ink that stands out from what is behind a picture.
Ink ink_behind(const RenderJob& job, const std::string& aov) {
    const bool is_scene = aov == "environment" && job.config.environment_behind;
    const bool on_white = job.looks.at(aov).on_white() || aov == "lines";
    return is_scene ? Ink::dark : ink_on(parse_background(job.config.background, on_white));
}

/// Where lines over a surface are light, as what is behind it is dark; nothing where all are dark.
std::vector<float> ink_beside_surface(const RenderJob& job, const std::string& aov,
                                      const Picture& drawn, const PicturePart& part) {
    if (!job.found_lines || aov == "lines" || ink_behind(job, aov) == Ink::dark) return {};
    return ink_plane(drawn, part.inside(), job.size.width, job.size.height);
}

/// What of the words of pictures has no room in them, and the first that lacks some.
struct Missing {
    bool legend = false, scale_bar = false;
    std::string file;

    std::string text() const {
        if (!legend && !scale_bar) return "";
        constexpr const char* kLegend = "legend, which is beside it as SVG";
        return fmt::format("{}: too small for its {}", file,
                           legend && scale_bar ? fmt::format("scale bar and its {}", kLegend)
                           : legend            ? kLegend
                                               : "scale bar");
    }
};

/// Legend, key and scale bar.
void burn_words(const RenderJob& job, const AovLook& look, const Canvas& canvas, Missing& missing) {
    const bool fit = look.words_fit;
    if (look.legend && job.config.legend)
        missing.legend |= !(fit && burn_legend(*look.legend, canvas, look.place));
    if (look.key && job.config.legend)
        missing.legend |= !(fit && burn_key(*look.key, canvas, look.place));
    if (job.config.scale_bar)
        missing.scale_bar |=
            !burn_scale_bar({job.size.width / job.camera.width, job.config.unit}, canvas,
                            look.bar_place);
}

/// The band of a drawn AOV as it is shown.
Picture finished_picture(const RenderJob& job, const std::string& aov, const Frames& frames,
                         const PicturePart& part, Missing& missing) {
    const AovLook& look = job.looks.at(aov);
    Picture picture = painted_aov(job, aov, look, frames);
    const std::vector<float> beside = ink_beside_surface(job, aov, picture, part);
    picture = crop(std::move(picture), part.inside());
    put_background(job, aov, part.wanted, picture);
    const Canvas canvas(picture, part.wanted.x, part.wanted.y, job.size.width, job.size.height);
    draw_height_labels(look.heights, canvas);
    if (job.found_lines)
        draw_lines(*job.found_lines, canvas,
                   {aov == "lines" ? ink_behind(job, aov) : Ink::dark, beside});
    burn_words(job, look, canvas, missing);
    return picture;
}

/// The parts of a frame that a data file holds, without the margin.
RenderedFrame without_margin(const RenderedFrame& frame, const PixelWindow& inside) {
    RenderedFrame out;
    out.size = frame.size;
    out.buffer = crop(frame.buffer, inside);
    out.truth_distance = crop(frame.truth_distance, frame.buffer.width, inside);
    out.open = crop(frame.open, frame.buffer.width, inside);
    return out;
}

void write_data(const RenderJob& job, const Frames& frames, const PicturePart& part,
                const ImageMetadata& metadata, PictureFiles& files) {
    // Colour may be averaged, data never: they come from the frame at the picture's own size.
    std::vector<ColorPlane> colors;
    const AovLook none;
    for (const std::string& aov : job.aovs)
        if (is_color(aov))
            colors.push_back({aov, crop(painted_aov(job, aov, none, frames), part.inside())});
    const RenderedFrame data = without_margin(frames.plain, part.inside());
    std::vector<std::vector<float>> planes;
    const DrawnLines lines = job.drawn_lines(part.wanted);
    files.add_exr(part.wanted.height, exr_channels(job.aovs, data, colors, lines, planes),
                  metadata);
}

void add_range(const RenderJob& job, const std::string& aov, ImageMetadata& metadata) {
    if (const auto& legend = job.looks.at(aov).legend)
        metadata["slim:range." + aov] =
            fmt::format("{:.17g} {:.17g}", legend->range.lo, legend->range.hi);
}

}  // namespace

bool has_background(const RenderConfig& config, const std::string& aov) {
    return (aov == "environment" && config.environment_behind) ||
           parse_background(config.background, false).alpha >= 1;
}

std::string write_band(const RenderJob& job, const Frames& frames, const PicturePart& part,
                       const ImageMetadata& metadata, PictureFiles& files) {
    Missing missing;
    for (std::size_t k = 0; k < job.plan.drawn.size(); ++k) {
        const std::string& aov = job.plan.drawn[k];
        ImageMetadata own = metadata;
        add_range(job, aov, own);
        files.add_png(k, finished_picture(job, aov, frames, part, missing),
                      has_background(job.config, aov), own);
        if (missing.file.empty() && (missing.legend || missing.scale_bar))
            missing.file = job.plan.pngs[k].string();
    }
    if (job.plan.exr.empty()) return missing.text();
    ImageMetadata of_data = metadata;
    for (const std::string& aov : job.plan.drawn) add_range(job, aov, of_data);  // the preview's
    write_data(job, frames, part, of_data, files);
    return missing.text();
}

std::vector<NamedText> legend_files(const RenderJob& job) {
    std::vector<NamedText> files;
    for (const std::string& aov : job.plan.drawn) {
        const AovLook& look = job.looks.at(aov);
        if (!job.config.legend || !look.on_white()) continue;
        files.push_back(
            {job.plan.legend(aov), look.legend ? legend_svg(*look.legend) : key_svg(*look.key)});
    }
    return files;
}

}  // namespace slim
