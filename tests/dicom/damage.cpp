// SPDX-License-Identifier: Apache-2.0
#include "damage.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <zlib.h>

namespace {

std::string from_hex(const std::string &hex)
{
    std::string bytes;
    for (size_t at = 0; at + 1 < hex.size(); at += 2)
        bytes.push_back(static_cast<char>(std::strtol(hex.substr(at, 2).c_str(), nullptr, 16)));
    return bytes;
}

// Returns the next number of splitmix64, as in tests/rng.h.
uint64_t next(uint64_t *state)
{
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

// Compresses bytes as a part of a raw deflate stream. The part contains no references to earlier parts.
std::string deflated(const std::string &plain, int flush)
{
    z_stream z = {};
    std::string out(plain.size() + 64, '\0');
    deflateInit2(&z, Z_BEST_COMPRESSION, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
    z.next_in = reinterpret_cast<Bytef *>(const_cast<char *>(plain.data()));
    z.avail_in = static_cast<uInt>(plain.size());
    z.next_out = reinterpret_cast<Bytef *>(&out[0]);
    z.avail_out = static_cast<uInt>(out.size());
    deflate(&z, flush);
    out.resize(z.total_out);
    deflateEnd(&z);
    return out;
}

// Returns a deflated data set of private attributes of 256 MB of zeros each. A megabyte is compressed once.
std::string bomb(int attributes)
{
    const std::string megabyte = deflated(std::string(1 << 20, '\0'), Z_FULL_FLUSH);
    std::string out;
    for (int n = 0; n < attributes; n++) {
        const char head[] = {9, 0, static_cast<char>(n), 0x10, 'O', 'B', 0, 0, 0, 0, 0, 0x10};
        out += deflated(std::string(head, sizeof head), Z_FULL_FLUSH);
        for (int m = 0; m < 256; m++)
            out += megabyte;
    }
    return out + deflated("", Z_FINISH);
}

bool apply(const change &c, std::string *bytes)
{
    const size_t star = c.text.find('*'), colon = c.text.find(':');
    const long count = star == std::string::npos ? 1 : std::atol(c.text.c_str() + star + 1);
    if (c.key == "cut") {
        const long size = std::atol(c.text.c_str()), all = static_cast<long>(bytes->size());
        bytes->resize(static_cast<size_t>(std::clamp(size < 0 ? all + size : size, 0L, all)));
    } else if (c.key == "replace") {
        const std::string from = from_hex(c.text.substr(0, colon));
        const size_t at = bytes->find(from);
        if (colon == std::string::npos || from.empty() || at == std::string::npos)
            return false;
        bytes->replace(at, from.size(), from_hex(c.text.substr(colon + 1)));
    } else if (c.key == "append") {
        const std::string more = from_hex(c.text.substr(0, star));
        for (long n = 0; n < count; n++)
            *bytes += more;
    } else if (c.key == "bomb") {
        // The file meta group is not deflated. Its first attribute contains the length of the group.
        const unsigned char *length = reinterpret_cast<const unsigned char *>(bytes->data()) + 140;
        bytes->resize(144 + (length[0] | size_t(length[1]) << 8));
        *bytes += bomb(std::atoi(c.text.c_str()));
    } else if (c.key == "flip") {
        uint64_t state = std::strtoull(c.text.c_str(), nullptr, 10);
        for (long n = 0; n < count && !bytes->empty(); n++) {
            const uint64_t bit = next(&state) % (8 * bytes->size());
            (*bytes)[bit / 8] = static_cast<char>((*bytes)[bit / 8] ^ 1 << bit % 8);
        }
    }
    return true;
}

} // namespace

bool damage_file(const series &s, int k, const std::string &path, std::string *error)
{
    std::ifstream in(path, std::ios::binary);
    const std::string before((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    std::string bytes = before;
    for (const change &c : s.changes) {
        if ((c.slice == k || c.slice == EVERY_SLICE) && !apply(c, &bytes)) {
            *error = path + ": " + c.key + "=" + c.text + " found nothing to change";
            return false;
        }
    }
    in.close();
    if (bytes != before)
        std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
    return true;
}
