// EXR through OpenEXR itself: channels are read as they lie, each in its own type.

#include "formats/exr_slice.h"
#include "formats/image_io.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <Imath/ImathBox.h>
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace slim {
namespace {

std::vector<float> floats_of(const std::vector<half>& values) {
    return std::vector<float>(values.begin(), values.end());
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

ChannelType channel_type(Imf::PixelType type) {
    return type == Imf::HALF   ? ChannelType::half_float
           : type == Imf::UINT ? ChannelType::uint32
                               : ChannelType::float32;
}

/// Room for a channel's values as a slice of the rows `band`; of halves in `half_values`.
Imf::Slice room_for(ExrImage::Channel& channel, std::vector<half>& half_values,
                    const Imath::Box2i& band) {
    const auto n = static_cast<std::size_t>(band.max.x - band.min.x + 1) *
                   static_cast<std::size_t>(band.max.y - band.min.y + 1);
    if (channel.type == ChannelType::uint32) {
        channel.integers.resize(n);
        return plane(Imf::UINT, channel.integers.data(), band);
    }
    if (channel.type == ChannelType::float32) {
        channel.floats.resize(n);
        return plane(Imf::FLOAT, channel.floats.data(), band);
    }
    half_values.resize(n);
    return plane(Imf::HALF, half_values.data(), band);
}

}  // namespace

struct ExrReader::State {
    std::string path;
    std::unique_ptr<Imf::InputFile> file;
    ExrImage header;
    Imath::Box2i window;
    int next_row = 0;

    template <class Body>
    void guarded(const Body& body) const {
        try {
            body();
        } catch (const std::exception& e) {
            throw FormatError(path + ": expected an EXR: " + e.what());
        }
    }
};

ExrReader::ExrReader(const std::string& path) : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.path = path;
    if (!std::filesystem::exists(path)) throw IoError({.file = path, .problem = "no such file"});
    s.guarded([&] {
        s.file = std::make_unique<Imf::InputFile>(path.c_str());
        s.window = s.file->header().dataWindow();
        s.header.width = s.window.max.x - s.window.min.x + 1;
        s.header.height = s.window.max.y - s.window.min.y + 1;
        read_header(s.file->header(), s.header);
        const Imf::ChannelList& channels = s.file->header().channels();
        for (auto it = channels.begin(); it != channels.end(); ++it)
            s.header.channels[it.name()].type = channel_type(it.channel().type);
    });
}

ExrReader::~ExrReader() = default;
ExrReader::ExrReader(ExrReader&&) noexcept = default;

const ExrImage& ExrReader::header() const { return state_->header; }

void ExrReader::read_rows(int n_rows, std::map<std::string, ExrImage::Channel>& channels) {
    State& s = *state_;
    SLIM_CHECK(s.next_row + n_rows, <=, s.header.height);
    const int y = s.window.min.y + s.next_row;
    const Imath::Box2i band({s.window.min.x, y}, {s.window.max.x, y + n_rows - 1});
    s.guarded([&] {
        std::map<std::string, std::vector<half>> half_values;
        Imf::FrameBuffer frame;
        for (const auto& [name, known] : s.header.channels) {
            ExrImage::Channel& channel = channels[name];
            channel.type = known.type;
            frame.insert(name, room_for(channel, half_values[name], band));
        }
        s.file->setFrameBuffer(frame);
        s.file->readPixels(band.min.y, band.max.y);
        for (auto& [name, channel] : channels)
            if (channel.type == ChannelType::half_float)
                channel.floats = floats_of(half_values[name]);
    });
    s.next_row += n_rows;
}

ExrImage read_exr(const std::string& path) {
    ExrReader reader(path);
    ExrImage image = reader.header();
    reader.read_rows(image.height, image.channels);
    return image;
}

}  // namespace slim
