#include "formats/ply_header.h"

#include "formats/message.h"
#include "formats/number_text.h"
#include "slim/base/error.h"

#include <array>
#include <charconv>
#include <utility>

namespace slim {
namespace {

/// Far above any real header; ends a search for end_header in something else.
constexpr std::uint64_t kLongestHeader = 100000;
constexpr std::size_t kMostProperties = 10000;

[[noreturn]] void fail(const ByteReader& in, const std::string& text) {
    throw FormatError(message(in.path(), ": line ", in.line_number(), ": ", text));
}

PlyType parse_type(const ByteReader& in, std::string_view word) {
    static constexpr std::array<std::pair<std::string_view, PlyType>, 18> kTypes{{
        {"char", PlyType::i8},     {"int8", PlyType::i8},      {"uchar", PlyType::u8},
        {"uint8", PlyType::u8},    {"short", PlyType::i16},    {"int16", PlyType::i16},
        {"ushort", PlyType::u16},  {"uint16", PlyType::u16},   {"int", PlyType::i32},
        {"int32", PlyType::i32},   {"uint", PlyType::u32},     {"uint32", PlyType::u32},
        {"int64", PlyType::i64},   {"uint64", PlyType::u64},   {"float", PlyType::f32},
        {"float32", PlyType::f32}, {"double", PlyType::f64},   {"float64", PlyType::f64},
    }};
    for (const auto& [name, type] : kTypes)
        if (name == word) return type;
    fail(in, message("expected a type (char to double, int8 to float64), found '", word, "'"));
}

PlyEncoding parse_encoding(const ByteReader& in, std::string_view line) {
    const std::string_view name = next_word(line);
    const std::string_view version = next_word(line);
    if (version != "1.0") fail(in, message("expected PLY version 1.0, found '", version, "'"));
    if (name == "ascii") return PlyEncoding::ascii;
    if (name == "binary_little_endian") return PlyEncoding::little_endian;
    if (name == "binary_big_endian") return PlyEncoding::big_endian;
    fail(in,
         message("expected ascii, binary_little_endian or binary_big_endian, found '", name, "'"));
}

PlyElement parse_element(const ByteReader& in, std::string_view line) {
    PlyElement element;
    element.name = next_word(line);
    const std::string_view count = next_word(line);
    const auto [stop, status] =
        std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (status != std::errc{} || stop != count.data() + count.size())
        fail(in, message("expected a count of element ", element.name, ", found '", count, "'"));
    return element;
}

PlyProperty parse_property(const ByteReader& in, std::string_view line) {
    PlyProperty property;
    std::string_view word = next_word(line);
    property.is_list = word == "list";
    if (property.is_list) {
        property.count_type = parse_type(in, next_word(line));
        if (!is_integer(property.count_type)) fail(in, "a list is counted by an integer type");
        word = next_word(line);
    }
    property.type = parse_type(in, word);
    property.name = next_word(line);
    if (property.name.empty()) fail(in, "expected the name of a property");
    return property;
}

void parse_noise(const ByteReader& in, std::string_view line, PlyHeader& header) {
    double& v = header.noise_variance;
    if (!parse_number(next_word(line), v) || !std::isfinite(v) || v < 0)
        fail(in, "expected a finite number, not below 0, after 'comment slim noise_variance'");
}

void parse_comment(const ByteReader& in, std::string_view line, PlyHeader& header) {
    const auto from = line.find_first_not_of(" \t");
    header.comments.emplace_back(from == std::string_view::npos ? "" : line.substr(from));
    if (next_word(line) != "slim") return;
    const std::string_view what = next_word(line);
    if (what == "noise_variance") parse_noise(in, line, header);
    if (what != "origin") return;
    Vec3d origin;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!parse_number(next_word(line), origin[axis]) || !std::isfinite(origin[axis]))
            fail(in, "expected three finite numbers after 'comment slim origin'");
    header.origin = origin;
}

void add_property(const ByteReader& in, std::string_view line, PlyHeader& header) {
    if (header.elements.empty()) fail(in, "a property before any element");
    PlyElement& element = header.elements.back();
    PlyProperty property = parse_property(in, line);
    if (element.find(property.name) >= 0)
        fail(in, message("element ", element.name, " has property ", property.name, " twice"));
    if (element.properties.size() >= kMostProperties) fail(in, "too many properties");
    element.properties.push_back(std::move(property));
}

/// Returns false at end_header.
bool parse_line(const ByteReader& in, std::string_view line, bool& has_format, PlyHeader& header) {
    const std::string_view keyword = next_word(line);
    if (keyword == "end_header") return false;
    if (keyword == "format") {
        header.encoding = parse_encoding(in, line);
        has_format = true;
    } else if (keyword == "element") {
        header.elements.push_back(parse_element(in, line));
    } else if (keyword == "property") {
        add_property(in, line, header);
    } else if (keyword == "comment") {
        parse_comment(in, line, header);
    } else if (keyword != "obj_info" && !keyword.empty()) {
        fail(in, message("expected format, element, property, comment or end_header, found '",
                         keyword.substr(0, 40), "'"));
    }
    return true;
}

}  // namespace

int PlyElement::find(const std::string& property) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
        if (properties[i].name == property) return static_cast<int>(i);
    return -1;
}

std::optional<std::size_t> PlyElement::fixed_size() const {
    std::size_t size = 0;
    for (const PlyProperty& p : properties) {
        if (p.is_list) return std::nullopt;
        size += size_of(p.type);
    }
    return size;
}

std::size_t PlyElement::least_row_size(PlyEncoding encoding) const {
    std::size_t size = 0;
    for (const PlyProperty& p : properties)
        size += encoding == PlyEncoding::ascii ? 2 : size_of(p.is_list ? p.count_type : p.type);
    return size;
}

const PlyElement* PlyHeader::find(const std::string& name) const {
    for (const PlyElement& e : elements)
        if (e.name == name) return &e;
    return nullptr;
}

PlyHeader read_ply_header(ByteReader& in) {
    PlyHeader header;
    std::string_view line;
    if (!in.read_line(line) || next_word(line) != "ply") fail(in, "expected 'ply'");
    bool has_format = false;
    do {
        if (!in.read_line(line) || in.line_number() > kLongestHeader)
            fail(in, "the header has no end_header; the file may be cut off");
    } while (parse_line(in, line, has_format, header));
    if (!has_format) fail(in, "the header has no format line");
    return header;
}

}  // namespace slim
