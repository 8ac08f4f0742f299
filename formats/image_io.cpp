// PNG through OpenImageIO; this file is its sole user.

#include "formats/image_io.h"

#include "formats/atomic_file.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string_view>

namespace slim {
namespace {

bool is_opaque(std::span<const std::uint8_t> rgba) {
    for (std::size_t i = 3; i < rgba.size(); i += 4)
        if (rgba[i] != 255) return false;
    return true;
}

std::vector<std::uint8_t> without_alpha(std::span<const std::uint8_t> rgba) {
    std::vector<std::uint8_t> rgb(rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < rgba.size() / 4; ++i)
        std::copy_n(&rgba[4 * i], 3, &rgb[3 * i]);
    return rgb;
}

OIIO::ImageSpec png_spec(int width, int height, int n_channels, const ImageMetadata& metadata) {
    OIIO::ImageSpec spec(width, height, n_channels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    // The bytes are unassociated already: without this OIIO would divide by alpha once more.
    spec.attribute("oiio:UnassociatedAlpha", 1);
    for (const auto& [name, value] : metadata) spec.attribute(name, value);
    return spec;
}

std::vector<unsigned char> encode_png(const std::string& path, const OIIO::ImageSpec& spec,
                                      const std::uint8_t* pixels) {
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("x.png", &memory);
    if (!output)
        throw IoError(path + ": no PNG writer: " + OIIO::geterror(), ExitCode::internal);
    if (!output->open("x.png", spec) || !output->write_image(OIIO::TypeDesc::UINT8, pixels) ||
        !output->close())
        throw IoError(path + ": cannot encode PNG: " + output->geterror(), ExitCode::resource);
    return bytes;
}

/// The file's channels (grey, grey + alpha, RGB or RGBA) as RGBA.
std::vector<std::uint8_t> widened(const std::vector<std::uint8_t>& in, std::size_t n_channels) {
    std::vector<std::uint8_t> out(in.size() / n_channels * 4, 255);
    const bool grey = n_channels < 3;
    for (std::size_t i = 0; i < in.size() / n_channels; ++i) {
        const std::uint8_t* p = &in[i * n_channels];
        for (std::size_t c = 0; c < 3; ++c) out[4 * i + c] = p[grey ? 0 : c];
        if (n_channels % 2 == 0) out[4 * i + 3] = p[n_channels - 1];
    }
    return out;
}

}  // namespace

void write_png_srgb8(const std::string& path, int width, int height,
                     std::span<const std::uint8_t> rgba, const ImageMetadata& metadata) {
    SLIM_CHECK(rgba.size(), ==,
               4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const bool opaque = is_opaque(rgba);
    const std::vector<std::uint8_t> rgb =
        opaque ? without_alpha(rgba) : std::vector<std::uint8_t>();
    const std::vector<unsigned char> bytes =
        encode_png(path, png_spec(width, height, opaque ? 3 : 4, metadata),
                   opaque ? rgb.data() : rgba.data());
    write_file_atomically(
        path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

PngImage read_png(const std::string& path) {
    if (!std::filesystem::exists(path)) throw IoError(path + ": no such file");
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path, &config);
    if (!input) throw FormatError(path + ": expected a PNG: " + OIIO::geterror());
    const OIIO::ImageSpec& spec = input->spec();
    PngImage image{spec.width, spec.height, spec.nchannels, {}, {}};
    std::vector<std::uint8_t> pixels(spec.image_pixels() *
                                     static_cast<std::size_t>(spec.nchannels));
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, pixels.data()))
        throw FormatError(path + ": damaged PNG: " + input->geterror());
    image.rgba = widened(pixels, static_cast<std::size_t>(spec.nchannels));
    for (const OIIO::ParamValue& p : spec.extra_attribs)
        if (p.type() == OIIO::TypeDesc::STRING) image.metadata[p.name().string()] = p.get_string();
    return image;
}

}  // namespace slim
