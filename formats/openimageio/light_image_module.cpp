// The sole user of OpenImageIO, a module that read_light_image loads.

#include "formats/image_io.h"
#include "slim/base/error.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <memory>

namespace slim {
namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;

float linear_from_srgb(float v) {
    return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

/// Floats of any channels as three, through the sRGB curve if they were integers.
std::vector<float> light_of(const std::vector<float>& in, std::size_t n_channels, bool is_srgb) {
    const std::size_t n_pixels = in.size() / n_channels;
    const bool grey = n_channels < 3;
    std::vector<float> rgb(3 * n_pixels);
    for (std::size_t i = 0; i < n_pixels; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const float v = in[i * n_channels + (grey ? 0 : c)];
            const float light = std::isfinite(v) && v > 0 ? v : 0;
            rgb[3 * i + c] = is_srgb ? linear_from_srgb(light) : light;
        }
    return rgb;
}

}  // namespace

extern "C" void slim_read_light_image(const std::string& path, LightImage& image) {
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path);
    if (!input)
        throw FormatError(path +
                          ": expected a picture (EXR, HDR, PNG, JPEG, TIFF): " + OIIO::geterror());
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 ||
        spec.image_pixels() > kMostPixels)
        throw FormatError(path + ": expected at most 268 million pixels, found " +
                          std::to_string(spec.width) + "x" + std::to_string(spec.height));
    std::vector<float> pixels(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()))
        throw FormatError(path + ": damaged picture: " + input->geterror());
    image = {spec.width, spec.height,
             light_of(pixels, static_cast<std::size_t>(spec.nchannels),
                      !spec.format.is_floating_point())};
}

}  // namespace slim
