// Files of solids with their cuts. Format: lib/docs/preparation.md.
#pragma once

#include <string>
#include <string_view>

#include "enamel/collision/solid.hpp"

namespace enamel {

/// Write a solid: its samples with and without cuts, and its layers. The file appears when it is complete
/// (FileWriter). Throws Error with the file and the cause. Realtime: no.
void saveSolid(const Solid& solid, const std::string& path);

/// Read a solid that saveSolid() wrote. All samples, layers and materials have the same bits, so queries and cuts give
/// the same results. Earlier strokes cannot be undone, but restore() gives the uncut solid. SolidLayer::within is null,
/// as its borders are in the samples. Realtime: no.
///
/// Throws ConfigurationError with the file for:
/// - a file that cannot be read, has more than 1 GiB, or was not written by saveSolid();
/// - another version, a wrong length or a wrong checksum;
/// - a value that no solid can have. The message then names the layer or brick.
Solid loadSolid(const std::string& path, int undoBricks = SolidOptions().undoBricks);

/// Read a solid from bytes in memory, as loadSolid(). `path` appears in messages.
Solid parseSolid(std::string_view bytes, const std::string& path, int undoBricks = SolidOptions().undoBricks);

}  // namespace enamel
