// PNG, and pictures of light, through OpenImageIO; this file is its sole user.

#include "formats/image_io.h"

#include "formats/atomic_file.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>

namespace slim {
namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;

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

/// OpenImageIO's stream over our atomic file. The PNG library is C: what fails is thrown once it
/// has returned.
class AtomicProxy : public OIIO::Filesystem::IOProxy {
public:
    explicit AtomicProxy(AtomicFile& file) : IOProxy("", Write), file_(file) {}
    const char* proxytype() const override { return "slim"; }
    std::size_t write(const void* bytes, std::size_t n) override {
        try {
            file_.write(bytes, n);
            m_pos += static_cast<std::int64_t>(n);
            return n;
        } catch (...) {
            failure_ = std::current_exception();
            return 0;
        }
    }
    std::size_t size() const override { return file_.size(); }
    void rethrow() const {
        if (failure_) std::rethrow_exception(failure_);
    }

private:
    AtomicFile& file_;
    std::exception_ptr failure_;
};

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

struct PngWriter::State {
    std::string path;
    int width = 0, next_row = 0;
    bool opaque = false;
    AtomicFile file;
    AtomicProxy proxy;
    std::unique_ptr<OIIO::ImageOutput> output;

    explicit State(const std::string& its_path) : path(its_path), file(its_path), proxy(file) {}
    void check(bool ok) {
        proxy.rethrow();
        if (!ok)
            throw IoError(path + ": cannot encode PNG: " + output->geterror(), ExitCode::resource);
    }
};

PngWriter::PngWriter(const std::string& path, int width, int height, bool opaque,
                     const ImageMetadata& metadata)
    : state_(std::make_unique<State>(path)) {
    State& s = *state_;
    s.width = width, s.opaque = opaque;
    s.output = OIIO::ImageOutput::create("x.png", &s.proxy);
    if (!s.output) throw IoError(path + ": no PNG writer: " + OIIO::geterror(), ExitCode::internal);
    s.check(s.output->open("x.png", png_spec(width, height, opaque ? 3 : 4, metadata)));
}

PngWriter::~PngWriter() = default;
PngWriter::PngWriter(PngWriter&&) noexcept = default;

void PngWriter::add_rows(std::span<const std::uint8_t> rgba) {
    State& s = *state_;
    SLIM_CHECK(rgba.size() % (4 * static_cast<std::size_t>(s.width)), ==, 0u);
    const int n = static_cast<int>(rgba.size() / 4 / static_cast<std::size_t>(s.width));
    const std::vector<std::uint8_t> rgb =
        s.opaque ? without_alpha(rgba) : std::vector<std::uint8_t>();
    s.check(s.output->write_scanlines(s.next_row, s.next_row + n, 0, OIIO::TypeDesc::UINT8,
                                      s.opaque ? rgb.data() : rgba.data()));
    s.next_row += n;
}

void PngWriter::seal() {
    state_->check(state_->output->close());
    state_->output.reset();
    state_->file.seal();
}

void PngWriter::commit() {
    if (state_->output) seal();
    state_->file.commit();
}

void write_png_srgb8(const std::string& path, int width, int height,
                     std::span<const std::uint8_t> rgba, const ImageMetadata& metadata) {
    SLIM_CHECK(rgba.size(), ==,
               4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    PngWriter writer(path, width, height, is_opaque(rgba), metadata);
    writer.add_rows(rgba);
    writer.commit();
}

LightImage read_light_image(const std::string& path) {
    if (!std::filesystem::exists(path)) throw IoError(path + ": no such file");
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
    return {spec.width, spec.height,
            light_of(pixels, static_cast<std::size_t>(spec.nchannels),
                     !spec.format.is_floating_point())};
}

struct PngReader::State {
    std::string path;
    std::unique_ptr<OIIO::ImageInput> input;
    PngImage header;
    int next_row = 0;
    std::vector<std::uint8_t> pixels;

    explicit State(const std::string& its_path) : path(its_path) {
        if (!std::filesystem::exists(path)) throw IoError(path + ": no such file");
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        input = OIIO::ImageInput::open(path, &config);
        if (!input) throw FormatError(path + ": expected a PNG: " + OIIO::geterror());
        const OIIO::ImageSpec& spec = input->spec();
        header = {spec.width, spec.height, spec.nchannels, {}, {}};
        for (const OIIO::ParamValue& p : spec.extra_attribs)
            if (p.type() == OIIO::TypeDesc::STRING) header.metadata[p.name().string()] = p.get_string();
    }
};

PngReader::PngReader(const std::string& path) : state_(std::make_unique<State>(path)) {}
PngReader::~PngReader() = default;
PngReader::PngReader(PngReader&&) noexcept = default;

const PngImage& PngReader::header() const { return state_->header; }

void PngReader::read_rows(int n_rows, std::vector<std::uint8_t>& rgba) {
    State& s = *state_;
    const int n_channels = s.header.n_file_channels;
    SLIM_CHECK(s.next_row + n_rows, <=, s.header.height);
    s.pixels.resize(static_cast<std::size_t>(s.header.width) * static_cast<std::size_t>(n_rows) *
                    static_cast<std::size_t>(n_channels));
    if (!s.input->read_scanlines(0, 0, s.next_row, s.next_row + n_rows, 0, 0, n_channels,
                                 OIIO::TypeDesc::UINT8, s.pixels.data()))
        throw FormatError(s.path + ": damaged PNG: " + s.input->geterror());
    s.next_row += n_rows;
    rgba = widened(s.pixels, static_cast<std::size_t>(n_channels));
}

PngImage read_png(const std::string& path) {
    PngReader reader(path);
    PngImage image = reader.header();
    reader.read_rows(image.height, image.rgba);
    return image;
}

}  // namespace slim
