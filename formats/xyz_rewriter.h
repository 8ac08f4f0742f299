#pragma once

#include "formats/atomic_file.h"
#include "formats/byte_reader.h"
#include "formats/cloud_rewriter.h"
#include "formats/row_encoder.h"
#include "formats/xyz_columns.h"

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace slim {

/// CloudRewriter of a text of coordinates, which keeps its columns, separators and byte order mark.
class XyzRewriter : public CloudRewriter {
public:
    XyzRewriter(const std::string& in, const std::string& out, double text_step);
    void write(std::span<const RewrittenPoint> points) override;
    void commit() override;

private:
    bool next_line();
    bool is_point() const;

    ByteReader in_;
    AtomicFile out_;
    XyzColumns columns_;
    std::vector<std::size_t> numbers_;  // columns that are written anew, ascending
    std::unique_ptr<RowEncoder> encoder_;
    std::string_view line_;
    std::vector<std::string_view> words_;
};

}  // namespace slim
