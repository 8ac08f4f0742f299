#pragma once

#include "formats/atomic_file.h"
#include "formats/byte_reader.h"
#include "formats/cloud_rewriter.h"
#include "formats/ply_rows.h"
#include "formats/row_encoder.h"

#include <memory>
#include <string>
#include <vector>

namespace slim {

/// CloudRewriter of a PLY of any encoding, with any further elements before and behind the
/// vertices.
class PlyRewriter : public CloudRewriter {
public:
    PlyRewriter(const std::string& in, const std::string& out, double text_step,
                double noise_variance);
    void write(std::span<const RewrittenPoint> points) override;
    void commit() override;

private:
    std::size_t vertex_index() const;
    void find_columns();
    void add_column(Quantity what, const char* name);
    void write_header(double noise_variance);
    std::string property_line(const std::string& line) const;
    std::string added_properties() const;
    void copy_element(const PlyElement& element);
    void write_records(std::span<const RewrittenPoint> points);
    void write_rows(std::span<const RewrittenPoint> points);
    void put(const RawRows& rows, std::span<const RewrittenPoint> points);

    ByteReader in_;
    PlyHeader header_;
    AtomicFile out_;
    std::size_t vertex_at_ = 0;          // of the header's elements
    std::vector<RowColumn> columns_;
    std::vector<std::size_t> properties_;  // of the columns that are read, ascending
    std::vector<std::string> added_names_;
    std::unique_ptr<RowEncoder> encoder_;
    std::unique_ptr<PlyRows> rows_;      // for what is not a fixed binary record
    std::size_t record_size_ = 0;        // 0: row by row
    std::uint64_t n_written_ = 0;
};

}  // namespace slim
