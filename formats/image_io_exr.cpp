// EXR through OpenEXR itself rather than OpenImageIO: planes are written as they lie, each in its
// own type, and the header holds what we put there and nothing else (no clock).

#include "formats/image_io.h"

#include "formats/atomic_file.h"
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
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <filesystem>
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

/// A slice of contiguous rows of T for the data window; the library only reads through the pointer
/// when it writes a file.
template <class T>
Imf::Slice plane(Imf::PixelType type, const T* values, const Imath::Box2i& data) {
    const auto width = static_cast<std::size_t>(data.max.x - data.min.x + 1);
    return Imf::Slice::Make(type, const_cast<T*>(values), data, sizeof(T), sizeof(T) * width);
}

std::vector<half> halves(std::span<const float> values) {
    std::vector<half> out(values.size());
    std::transform(values.begin(), values.end(), out.begin(), [](float v) { return half(v); });
    return out;
}

std::vector<float> floats_of(const std::vector<half>& values) {
    return std::vector<float>(values.begin(), values.end());
}

void check_planes(std::span<const ExrChannel> channels, std::size_t n_pixels) {
    for (const ExrChannel& c : channels)
        SLIM_CHECK(c.type == ChannelType::uint32 ? c.integers.size() : c.floats.size(), ==,
                   n_pixels);
}

/// Fills the frame buffer; half planes are converted into `converted`, which must outlive it.
Imf::FrameBuffer frame_of(std::span<const ExrChannel> channels, const Imath::Box2i& data,
                          std::vector<std::vector<half>>& converted) {
    Imf::FrameBuffer frame;
    for (const ExrChannel& c : channels) {
        if (c.type == ChannelType::half_float) {
            converted.push_back(halves(c.floats));
            frame.insert(c.name, plane(Imf::HALF, converted.back().data(), data));
        } else if (c.type == ChannelType::uint32) {
            frame.insert(c.name, plane(Imf::UINT, c.integers.data(), data));
        } else {
            frame.insert(c.name, plane(Imf::FLOAT, c.floats.data(), data));
        }
    }
    return frame;
}

void read_header(const Imf::Header& header, ExrImage& image) {
    image.has_chromaticities = Imf::hasChromaticities(header);
    image.zip = header.compression() == Imf::ZIP_COMPRESSION;
    for (auto it = header.begin(); it != header.end(); ++it) {
        const Imf::Attribute& attribute = it.attribute();
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute))
            image.metadata[it.name()] = text->value();
        if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&attribute))
            std::copy_n(matrix->value().getValue(), 16, image.matrices[it.name()].begin());
    }
}

ExrImage::Channel read_channel(Imf::InputFile& file, const Imath::Box2i& window,
                               const std::string& name, Imf::PixelType type) {
    const auto width = static_cast<std::size_t>(window.max.x - window.min.x + 1);
    const std::size_t n = width * static_cast<std::size_t>(window.max.y - window.min.y + 1);
    ExrImage::Channel channel;
    std::vector<half> half_values;
    const auto read = [&](auto& values) {
        values.resize(n);
        Imf::FrameBuffer frame;
        frame.insert(name, Imf::Slice::Make(type, values.data(), window, sizeof(values[0]),
                                            sizeof(values[0]) * width));
        file.setFrameBuffer(frame);
        file.readPixels(window.min.y, window.max.y);
    };
    if (type == Imf::HALF) read(half_values);
    if (type == Imf::FLOAT) read(channel.floats);
    if (type == Imf::UINT) read(channel.integers);
    if (type == Imf::HALF) channel.floats = floats_of(half_values);
    channel.type = type == Imf::HALF   ? ChannelType::half_float
                   : type == Imf::UINT ? ChannelType::uint32
                                       : ChannelType::float32;
    return channel;
}

}  // namespace

struct ExrWriter::State {
    int width = 0, next_row = 0;
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
        s.output->setFrameBuffer(frame_of(channels, band, converted));
        s.output->writePixels(n_rows);
    });
    s.next_row += n_rows;
}

void ExrWriter::commit() {
    state_->guarded([&] { state_->output.reset(); });
    state_->file.commit();
}

void write_exr(const std::string& path, int width, int height, std::span<const ExrChannel> channels,
               const ImageMetadata& metadata, const ImageMatrices& matrices,
               const ImagePlace& place) {
    ExrWriter writer(path, width, height, channels, metadata, matrices, place);
    writer.add_rows(height, channels);
    writer.commit();
}

ExrImage read_exr(const std::string& path) {
    if (!std::filesystem::exists(path)) throw IoError(path + ": no such file");
    try {
        Imf::InputFile file(path.c_str());
        const Imath::Box2i window = file.header().dataWindow();
        ExrImage image;
        image.width = window.max.x - window.min.x + 1;
        image.height = window.max.y - window.min.y + 1;
        read_header(file.header(), image);
        const Imf::ChannelList& channels = file.header().channels();
        for (auto it = channels.begin(); it != channels.end(); ++it)
            image.channels[it.name()] = read_channel(file, window, it.name(), it.channel().type);
        return image;
    } catch (const std::exception& e) {
        throw FormatError(path + ": expected an EXR: " + e.what());
    }
}

}  // namespace slim
