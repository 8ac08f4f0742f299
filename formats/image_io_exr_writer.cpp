// EXR through OpenEXR itself rather than OpenImageIO: planes are written as they lie, each in its
// own type, and the header holds what we put there and nothing else (no clock).

#include "formats/atomic_file.h"
#include "formats/exr_slice.h"
#include "formats/image_io.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <Imath/ImathBox.h>
#include <Imath/ImathMatrix.h>
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

namespace slim {
namespace {

/// OpenEXR's stream over our atomic file.
class AtomicStream : public Imf::OStream {
public:
    explicit AtomicStream(AtomicFile& file) : OStream(file.path().c_str()), file_(file) {}
    void write(const char bytes[], int n) override {
        file_.write_at(at_, bytes, static_cast<std::size_t>(n));
        at_ += static_cast<std::uint64_t>(n);
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t at) override { at_ = at; }

private:
    AtomicFile& file_;
    std::uint64_t at_ = 0;
};

Imf::PixelType pixel_type(ChannelType type) {
    return type == ChannelType::half_float ? Imf::HALF
           : type == ChannelType::uint32   ? Imf::UINT
                                           : Imf::FLOAT;
}

std::string exr_name(const std::string& name) {
    return name == "DateTime"           ? "capDate"
           : name == "ImageDescription" ? "comments"
           : name == "Copyright"        ? "owner"
                                        : name;
}

Imf::Header make_header(const Imath::Box2i& data, const ImagePlace& place,
                        std::span<const ExrChannel> channels, const ImageMetadata& metadata,
                        const ImageMatrices& matrices) {
    const Imath::V2i last = place.whole_width > 0
                                ? Imath::V2i(place.whole_width - 1, place.whole_height - 1)
                                : data.max;
    Imf::Header header(Imath::Box2i({0, 0}, last), data);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::addChromaticities(header, Imf::Chromaticities());  // the default is Rec.709 with D65
    for (const auto& [name, value] : metadata)
        header.insert(exr_name(name), Imf::StringAttribute(value));
    for (const auto& [name, values] : matrices) {
        Imath::M44f m;
        std::copy(values.begin(), values.end(), m.getValue());
        header.insert(name, Imf::M44fAttribute(m));
    }
    for (const ExrChannel& c : channels)
        header.channels().insert(c.name, Imf::Channel(pixel_type(c.type)));
    return header;
}

/// Values beyond the largest half, which would become infinite, are held at it and counted.
std::vector<half> halves(std::span<const float> values, std::uint64_t& n_clamped) {
    std::vector<half> out(values.size());
    std::transform(values.begin(), values.end(), out.begin(), [&](float v) {
        if (std::abs(v) <= kLargestHalf) return half(v);
        if (std::isnan(v)) return half(v);
        ++n_clamped;
        return half(std::copysign(kLargestHalf, v));
    });
    return out;
}

void check_planes(std::span<const ExrChannel> channels, std::size_t n_pixels) {
    for (const ExrChannel& c : channels)
        SLIM_CHECK(c.type == ChannelType::uint32 ? c.integers.size() : c.floats.size(), ==,
                   n_pixels);
}

/// Fills the frame buffer; half planes are converted into `converted`, which must outlive it.
Imf::FrameBuffer frame_of(std::span<const ExrChannel> channels, const Imath::Box2i& data,
                          std::vector<std::vector<half>>& converted, std::uint64_t& n_clamped) {
    Imf::FrameBuffer frame;
    for (const ExrChannel& c : channels) {
        if (c.type == ChannelType::half_float) {
            converted.push_back(halves(c.floats, n_clamped));
            frame.insert(c.name, plane(Imf::HALF, converted.back().data(), data));
        } else if (c.type == ChannelType::uint32) {
            frame.insert(c.name, plane(Imf::UINT, c.integers.data(), data));
        } else {
            frame.insert(c.name, plane(Imf::FLOAT, c.floats.data(), data));
        }
    }
    return frame;
}

}  // namespace

struct ExrWriter::State {
    int width = 0, next_row = 0;
    std::uint64_t n_clamped = 0;
    ImagePlace place;
    AtomicFile file;
    AtomicStream stream;
    std::unique_ptr<Imf::OutputFile> output;

    explicit State(const std::string& path) : file(path), stream(file) {}

    template <class Body>
    void guarded(const Body& body) {
        try {
            body();
        } catch (const Error&) {
            throw;
        } catch (const std::exception& e) {
            throw IoError(file.path() + ": cannot write EXR: " + e.what(), ExitCode::resource);
        }
    }
};

ExrWriter::ExrWriter(const std::string& path, int width, int height,
                     std::span<const ExrChannel> channels, const ImageMetadata& metadata,
                     const ImageMatrices& matrices, const ImagePlace& place)
    : state_(std::make_unique<State>(path)) {
    State& s = *state_;
    s.width = width, s.place = place;
    s.guarded([&] {
        const Imath::Box2i data({place.x, place.y}, {place.x + width - 1, place.y + height - 1});
        s.output = std::make_unique<Imf::OutputFile>(
            s.stream, make_header(data, place, channels, metadata, matrices));
    });
}

ExrWriter::~ExrWriter() = default;
ExrWriter::ExrWriter(ExrWriter&&) noexcept = default;

void ExrWriter::add_rows(int n_rows, std::span<const ExrChannel> channels) {
    State& s = *state_;
    check_planes(channels, static_cast<std::size_t>(s.width) * static_cast<std::size_t>(n_rows));
    const int y = s.place.y + s.next_row;
    const Imath::Box2i band({s.place.x, y}, {s.place.x + s.width - 1, y + n_rows - 1});
    s.guarded([&] {
        std::vector<std::vector<half>> converted;
        s.output->setFrameBuffer(frame_of(channels, band, converted, s.n_clamped));
        s.output->writePixels(n_rows);
    });
    s.next_row += n_rows;
}

std::uint64_t ExrWriter::n_clamped() const { return state_->n_clamped; }

void ExrWriter::seal() {
    state_->guarded([&] { state_->output.reset(); });
    state_->file.seal();
}

void ExrWriter::commit() {
    if (state_->output) seal();
    state_->file.commit();
}

void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               const ImageMetadata& metadata, const ImageMatrices& matrices,
               const ImagePlace& place) {
    ExrWriter writer(path, width, height, channels, metadata, matrices, place);
    writer.add_rows(height, channels);
    writer.commit();
}

}  // namespace slim
