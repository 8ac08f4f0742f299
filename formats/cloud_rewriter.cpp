#include "formats/cloud_rewriter.h"

#include "formats/byte_reader.h"
#include "formats/cloud_endings.h"
#include "formats/cloud_kind.h"
#include "formats/extension.h"
#include "formats/message.h"
#include "formats/ply_rewriter.h"
#include "formats/xyz_rewriter.h"
#include "slim/base/error.h"

namespace slim {
namespace {

/// Points keep the format that they came in: a text has no names or types for attributes.
void check_extension(const std::string& in, CloudKind kind, const std::string& out) {
    const std::string extension = lower_extension(out);
    if (extension == ".gz")
        throw ConfigError(
            {.file = out,
             .problem = "the output is written unpacked, that of a gzip file too: leave out .gz, "
                        "and pack it afterwards with gzip"});
    if (kind == CloudKind::ply ? extension == ".ply" : is_text_ending(extension)) return;
    const bool is_ply = kind == CloudKind::ply;
    throw ConfigError(
        {.file = out,
         .problem = message("the output has the format of the input, and ", in, " is ",
                            is_ply ? "a PLY" : "a text of coordinates"),
         .expected = "a name ending in " + (is_ply ? ".ply" : text_endings(", ", " or "))});
}

}  // namespace

std::unique_ptr<CloudRewriter> rewrite_cloud(const std::string& in, const std::string& out,
                                             double text_step, double noise_variance) {
    const CloudKind kind = cloud_kind(in, ByteReader(in).peek(4096).substr(0, 4096));
    check_extension(in, kind, out);
    if (kind == CloudKind::ply)
        return std::make_unique<PlyRewriter>(in, out, text_step, noise_variance);
    return std::make_unique<XyzRewriter>(in, out, text_step);
}

}  // namespace slim
