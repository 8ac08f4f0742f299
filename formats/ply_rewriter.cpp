#include "formats/ply_rewriter.h"

#include "formats/message.h"
#include "formats/number_text.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <algorithm>
#include <array>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 23;

constexpr std::array<std::pair<Quantity, const char*>, 7> kNames{{
    {Quantity::x, "x"}, {Quantity::y, "y"}, {Quantity::z, "z"},
    {Quantity::nx, "nx"}, {Quantity::ny, "ny"}, {Quantity::nz, "nz"},
    {Quantity::displacement, "scalar_displacement"},
}};

/// Whether a comment is the one that PlyHeader::noise_variance is read of.
bool says_noise(std::string_view comment) {
    return next_word(comment) == "slim" && next_word(comment) == "noise_variance";
}

/// What a number of this type is written as: integers could not hold the new value.
PlyType written_type(PlyType type, Quantity what) {
    if (!is_integer(type)) return type;
    return what <= Quantity::z ? PlyType::f64 : PlyType::f32;
}

}  // namespace

PlyRewriter::PlyRewriter(const std::string& in, const std::string& out, double text_step,
                         double noise_variance)
    : in_(in), header_(read_ply_header(in_)), out_(out), vertex_at_(vertex_index()) {
    find_columns();
    encoder_ = std::make_unique<RowEncoder>(header_.encoding, columns_,
                                            header_.origin.value_or(Vec3d{}), text_step);
    write_header(noise_variance);
    for (std::size_t e = 0; e < vertex_at_; ++e) copy_element(header_.elements[e]);
    const PlyElement& vertex = header_.elements[vertex_at_];
    check_ply_count(in_, vertex, header_.encoding);
    const auto size = vertex.fixed_size();
    if (header_.encoding != PlyEncoding::ascii && size) {
        record_size_ = *size;
    } else {
        rows_ = std::make_unique<PlyRows>(in_, header_, vertex);
        rows_->keep_raw();
    }
}

std::size_t PlyRewriter::vertex_index() const {
    const PlyElement* vertex = header_.find("vertex");
    if (!vertex) vertex = header_.find("point");
    if (!vertex) throw FormatError(message(in_.path(), ": expected an element vertex (or point)"));
    return static_cast<std::size_t>(vertex - header_.elements.data());
}

/// Columns that are read stand in the order of the row, those that are added behind them.
void PlyRewriter::find_columns() {
    const PlyElement& vertex = header_.elements[vertex_at_];
    for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
        const PlyProperty& p = vertex.properties[i];
        const auto known = std::find_if(kNames.begin(), kNames.end(),
                                        [&](const auto& name) { return p.name == name.second; });
        if (known == kNames.end()) continue;
        if (p.is_list)
            throw FormatError(
                message(in_.path(), ": property ", p.name,
                        " of the vertices is a list: expected a number, as it is to be rewritten"));
        columns_.push_back({known->first, written_type(p.type, known->first), p.type});
        properties_.push_back(i);
    }
    for (const auto& [what, name] : kNames) add_column(what, name);
}

void PlyRewriter::add_column(Quantity what, const char* name) {
    const auto has = [&](const RowColumn& column) { return column.what == what; };
    if (std::any_of(columns_.begin(), columns_.end(), has)) return;
    columns_.push_back({what, PlyType::f32, std::nullopt});
    added_names_.push_back(name);
}

std::string PlyRewriter::added_properties() const {
    std::string text;
    for (const std::string& name : added_names_) text += "property float " + name + '\n';
    return text;
}

/// The line of a vertex property; another type where that is not kept.
std::string PlyRewriter::property_line(const std::string& line) const {
    std::string_view rest = line;
    next_word(rest), next_word(rest);
    const std::string_view name = next_word(rest);
    const PlyElement& vertex = header_.elements[vertex_at_];
    for (std::size_t c = 0; c < properties_.size(); ++c) {
        const RowColumn& column = columns_[c];
        if (vertex.properties[properties_[c]].name == name && column.type != *column.in_type)
            return message("property ", column.type == PlyType::f64 ? "double " : "float ", name);
    }
    return line;
}

/// The lines of the header as they are, but for the properties of a vertex and what is said of
/// noise: the most of it, once.
void PlyRewriter::write_header(double noise_variance) {
    ByteReader lines(in_.path());
    const double noise = std::max(noise_variance, header_.noise_variance);
    bool in_vertex = false;
    for (std::string_view view; lines.read_line(view);) {
        const std::string line(view);
        std::string_view rest = line;
        const std::string_view keyword = next_word(rest);
        if (keyword == "comment" && says_noise(rest)) continue;
        const bool ends = keyword == "end_header";
        if (in_vertex && (ends || keyword == "element")) out_.write(added_properties());
        if (ends || keyword == "element")
            in_vertex = next_word(rest) == header_.elements[vertex_at_].name;
        out_.write((in_vertex && keyword == "property" ? property_line(line) : line) + '\n');
        if (keyword == "format" && noise > 0)
            out_.write(message("comment slim noise_variance ", noise, '\n'));
        if (ends) return;
    }
}

void PlyRewriter::copy_element(const PlyElement& element) {
    check_ply_count(in_, element, header_.encoding);
    PlyRows rows(in_, header_, element);
    rows.keep_raw();
    while (rows.next()) {
        out_.write(rows.raw());
        if (header_.encoding == PlyEncoding::ascii) out_.write("\n");
    }
}

void PlyRewriter::put(const RawRows& rows, std::span<const RewrittenPoint> points) {
    for (const std::string& piece : encoder_->encode(rows, points)) out_.write(piece);
}

void PlyRewriter::write(std::span<const RewrittenPoint> points) {
    n_written_ += points.size();
    SLIM_CHECK(n_written_, <=, header_.elements[vertex_at_].count);
    if (record_size_ > 0) write_records(points);
    else write_rows(points);
}

void PlyRewriter::write_records(std::span<const RewrittenPoint> points) {
    const PlyElement& vertex = header_.elements[vertex_at_];
    RawRows rows;
    rows.fixed_size = record_size_;
    for (const std::size_t property : properties_) {
        std::size_t begin = 0;
        for (std::size_t i = 0; i < property; ++i) begin += size_of(vertex.properties[i].type);
        rows.slots.push_back({begin, begin + size_of(vertex.properties[property].type)});
    }
    const std::size_t block = std::max<std::size_t>(1, kBlockBytes / record_size_);
    for (std::size_t done = 0; done < points.size();) {
        const std::size_t n = std::min(block, points.size() - done);
        rows.bytes = in_.peek(n * record_size_).substr(0, n * record_size_);
        if (rows.bytes.size() < n * record_size_)
            throw FormatError(message(in_.path(), ": byte ", in_.offset(),
                                      ": the file has become shorter while it was read"));
        put(rows, points.subspan(done, n));
        in_.advance(n * record_size_);
        done += n;
    }
}

void PlyRewriter::write_rows(std::span<const RewrittenPoint> points) {
    RawRows rows;
    std::string bytes;
    for (std::size_t i = 0; i < points.size() && rows_->next(); ++i) {
        bytes += rows_->raw();
        rows.row_end.push_back(bytes.size());
        for (const std::size_t property : properties_) {
            const PlyRows::Range range = rows_->range(property);
            rows.slots.push_back({range.begin, range.end});
        }
    }
    rows.bytes = bytes;
    put(rows, points.first(rows.row_end.size()));
}

void PlyRewriter::commit() {
    SLIM_CHECK(n_written_, ==, header_.elements[vertex_at_].count);
    for (std::size_t e = vertex_at_ + 1; e < header_.elements.size(); ++e)
        copy_element(header_.elements[e]);
    out_.commit();
}

}  // namespace slim
