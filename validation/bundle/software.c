/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/software.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/digest.h>
#include "core/memory_stream.h"
#include "validation/bundle/csv.h"

/* A row of the table of software below, for the libraries whose file names have the prefix `begins`. */
typedef struct known {
    const char *begins, *name, *maker, *licence, *purpose, *limits, *anomalies;
} known;

#define GCC_EXCEPTION "GPL-3.0-or-later WITH GCC-exception-3.1"
static const known table[] = {
    {"libcrypto.so", "OpenSSL", "OpenSSL Software Foundation", "Apache-2.0", "SHA-256 of grids, files and the manifest",
     "decides no voxel; equality is a comparison of bytes and does not rest on it",
     "https://openssl-library.org/news/vulnerabilities/"},
    {"libz.so", "zlib", "J. Gailly and M. Adler", "Zlib", "gzip in NRRD and NIfTI files, PNG",
     "reads files; not used by generated cases", "https://github.com/madler/zlib/issues"},
    {"libjansson.so", "Jansson", "P. Lehtinen", "MIT", "JSON: --json and this bundle's files",
     "writes the verdict down and does not make it", "https://github.com/akheron/jansson/issues"},
    {"libassimp.so", "Open Asset Import Library", "assimp team", "BSD-3-Clause", "reads meshes: STL, OBJ, PLY, 3DS",
     "not used by generated cases", "https://github.com/assimp/assimp/issues"},
    {"libnifti", "NIfTI library", "NIfTI Data Format Working Group", "NOASSERTION", "reads and writes NIfTI volumes",
     "not used by generated cases; its licence is the public domain",
     "https://github.com/NIFTI-Imaging/nifti_clib/issues"},
    {"libznz.so", "NIfTI library", "NIfTI Data Format Working Group", "NOASSERTION", "gzip for the NIfTI library",
     "not used by generated cases; its licence is the public domain",
     "https://github.com/NIFTI-Imaging/nifti_clib/issues"},
    {"libpng", "libpng", "PNG Development Group", "libpng-2.0", "pictures",
     "pictures illustrate; what is compared are voxels", "https://github.com/pnggroup/libpng/issues"},
    {"libtiff", "libtiff", "S. Leffler and Silicon Graphics", "libtiff", "reads stacks of TIFF slices",
     "not used by generated cases", "https://gitlab.com/libtiff/libtiff/-/issues"},
    {"libembree", "Embree", "Intel Corporation", "Apache-2.0",
     "finds candidate triangles for the voxelizer cpu:voxelizer=embree",
     "not exact at edges by design; proposes only, integers decide", "https://github.com/RenderKit/embree/issues"},
    {"libtbb", "oneTBB", "UXL Foundation", "Apache-2.0", "threads of Embree",
     "order of work is not fixed; no result depends on it", "https://github.com/uxlfoundation/oneTBB/issues"},
    {"libOpenCL.so", "OpenCL ICD loader", "B. Videau and others (ocl-icd) or the Khronos Group", "BSD-2-Clause",
     "finds OpenCL drivers", "skips drivers that it cannot load and says nothing",
     "https://github.com/OCL-dev/ocl-icd/issues"},
    {"libpocl", "Portable Computing Language", "PoCL developers", "MIT", "OpenCL on the processor",
     "contracts floats by default and installs a handler of SIGFPE; kernels here use integers alone, each backend a "
     "process of its own",
     "https://github.com/pocl/pocl/issues"},
    {"libLLVM", "LLVM", "LLVM project", "Apache-2.0 WITH LLVM-exception", "compiles kernels for OpenCL drivers",
     "a compiler may err; that is what this comparison looks for", "https://github.com/llvm/llvm-project/issues"},
    {"libclang", "Clang", "LLVM project", "Apache-2.0 WITH LLVM-exception", "compiles kernels for OpenCL drivers",
     "a compiler may err; that is what this comparison looks for", "https://github.com/llvm/llvm-project/issues"},
    {"libRusticlOpenCL", "Mesa rusticl", "Mesa developers", "MIT", "an OpenCL driver",
     "lists no device unless RUSTICL_ENABLE names one", "https://gitlab.freedesktop.org/mesa/mesa/-/issues"},
    {"libMesaOpenCL", "Mesa Clover", "Mesa developers", "MIT", "an OpenCL driver",
     "OpenCL 1.1 on most devices: refused here", "https://gitlab.freedesktop.org/mesa/mesa/-/issues"},
    {"libnvidia-opencl", "NVIDIA OpenCL driver", "NVIDIA Corporation", "LicenseRef-proprietary", "an OpenCL driver",
     "its source is closed", "https://developer.nvidia.com/bugs"},
    {"libamdocl", "ROCm OpenCL runtime", "Advanced Micro Devices", "MIT", "an OpenCL driver",
     "miscompiled integer code in past versions (ROCm 1764, 1383); fingerprints look for those",
     "https://github.com/ROCm/ROCm/issues"},
    {"libigdrcl", "Intel compute runtime", "Intel Corporation", "MIT", "an OpenCL driver",
     "none known that concerns integers", "https://github.com/intel/compute-runtime/issues"},
    {"libgomp.so", "GNU OpenMP", "Free Software Foundation", GCC_EXCEPTION, "threads of the backend cpu",
     "order of work is not fixed; no result depends on it", "https://gcc.gnu.org/bugzilla/"},
    {"libomp.so", "LLVM OpenMP", "LLVM project", "Apache-2.0 WITH LLVM-exception", "threads of the backend cpu",
     "order of work is not fixed; no result depends on it", "https://github.com/llvm/llvm-project/issues"},
    {"libgcc_s.so", "GCC runtime", "Free Software Foundation", GCC_EXCEPTION, "arithmetic of 128 bits, unwinding",
     "none known", "https://gcc.gnu.org/bugzilla/"},
    {"libstdc++.so", "GNU C++ library", "Free Software Foundation", GCC_EXCEPTION, "for libraries in C++",
     "none known that concerns osteon", "https://gcc.gnu.org/bugzilla/"},
    {"libc.so", "GNU C library", "Free Software Foundation", "LGPL-2.1-or-later", "files, memory, processes, text",
     "no function of libm decides a voxel", "https://sourceware.org/bugzilla/"},
    {"libm.so", "GNU C library", "Free Software Foundation", "LGPL-2.1-or-later", "phantoms, paths, pictures",
     "no function of libm decides a voxel", "https://sourceware.org/bugzilla/"},
    {"libdl.so", "GNU C library", "Free Software Foundation", "LGPL-2.1-or-later", "loads drivers and plugins",
     "none known", "https://sourceware.org/bugzilla/"},
    {"libpthread.so", "GNU C library", "Free Software Foundation", "LGPL-2.1-or-later", "threads", "none known",
     "https://sourceware.org/bugzilla/"},
    {"ld-linux", "GNU C library", "Free Software Foundation", "LGPL-2.1-or-later", "loads the program", "none known",
     "https://sourceware.org/bugzilla/"},
};

static const known unknown = {"",
                              "",
                              "NOASSERTION",
                              "NOASSERTION",
                              "brought along by another library",
                              "none recorded: to be judged by the user of this bundle",
                              ""};

static const known *known_of(const char *soname)
{
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++)
        if (strncmp(soname, table[i].begins, strlen(table[i].begins)) == 0)
            return &table[i];
    return &unknown;
}

/* true after an allocation outside Jansson failed; if an allocation in Jansson fails, the program terminates
   (app/main.c) */
static bool out_of_memory;

/* ----------------------------------------------------------- the libraries */

static int by_file(const void *a, const void *b)
{
    const json_t *x = *(json_t *const *)a, *y = *(json_t *const *)b;
    const int order = strcmp(evidence_text(x, "file"), evidence_text(y, "file"));
    return order ? order : strcmp(evidence_text(x, "sha256"), evidence_text(y, "sha256"));
}

/* Returns the libraries of one machine or of all shards, without duplicates. Returns NULL if memory is exhausted. The
   caller owns the result. */
static json_t *libraries_of(const json_t *tools)
{
    json_t *all = json_array(), *seen = json_object(), *out = json_array();
    const json_t *one;
    for (size_t i = 0; (one = evidence_part(tools, "libraries", i)); i++)
        json_array_extend(all, json_object_get(one, "libraries"));
    const size_t count = json_array_size(all);
    json_t **rows = calloc(count + 1, sizeof *rows);
    out_of_memory |= !rows;
    for (size_t i = 0; rows && i < count; i++)
        rows[i] = json_array_get(all, i);
    if (rows)
        qsort(rows, count, sizeof *rows, by_file);
    for (size_t i = 0; rows && i < count; i++) {
        char key[1200];
        snprintf(key, sizeof key, "%.1000s %.80s", evidence_text(rows[i], "file"), evidence_text(rows[i], "sha256"));
        if (!json_object_get(seen, key)) {
            json_object_set_new(seen, key, json_true());
            json_array_append(out, rows[i]);
        }
    }
    free(rows);
    json_decref(seen);
    json_decref(all);
    return out;
}

/* Returns the value of a key in tools.json, or NULL if there is none. In a merged bundle, this is the value of the
   first shard. */
static const json_t *part_of(const json_t *tools, const char *key)
{
    return json_object_get(evidence_part(tools, key, 0), key);
}

/* ------------------------------------------------------------------ files */

/* Returns the licence from the table or, if the table has none, from the package. Returns NOASSERTION if neither is
   available. */
static const char *licence_of(const known *k, const json_t *library)
{
    const char *its = evidence_text(library, "licence");
    return strcmp(k->licence, "NOASSERTION") == 0 && *its ? its : k->licence;
}

/* Returns the supplier of a library: the maintainer of its package or, if it is not part of a package, the maker of
   the software. */
static const char *supplier_of(const known *k, const json_t *library)
{
    return *evidence_text(library, "maintainer") ? evidence_text(library, "maintainer") : k->maker;
}

static const known *compiler_of(const char *text)
{
    static const known gcc = {"", "GCC", "Free Software Foundation",     GCC_EXCEPTION,
                              "", "",    "https://gcc.gnu.org/bugzilla/"};
    return strstr(text, "clang")                                 ? known_of("libclang")
           : strncmp(text, "gcc", 3) == 0 || strstr(text, "GCC") ? &gcc
                                                                 : &unknown;
}

/* Finds the row of a library in the table, by its name in pkg-config. */
static const known *headers_of(const char *name)
{
    char soname[64];
    snprintf(soname, sizeof soname, "%s%.40s.so", strncmp(name, "lib", 3) == 0 ? "" : "lib",
             strcmp(name, "zlib") == 0 ? "z" : name);
    return known_of(soname);
}

/* Writes a CSV row for a tool or library that is used only to build osteon. */
static void put_build(FILE *to, const known *k, const char *name, const char *version, const char *purpose,
                      const char *limits)
{
    put_csv(to, name, ',');
    put_csv(to, version, ',');
    put_csv(to, k->maker, ',');
    put_csv(to, purpose, ',');
    put_csv(to, k->licence, ',');
    put_csv(to, limits, ',');
    put_csv(to, k->anomalies, ',');
    fputs(",\"build\",\"\",\"\",\"\"\n", to);
}

static void soup(FILE *to, json_t *tools)
{
    json_t *libraries = libraries_of(tools);
    const json_t *build = part_of(tools, "build");
    const char *name;
    json_t *version;
    fputs("name,version,manufacturer,purpose,licence,known limits,anomalies published at,anomalies reviewed on,how it "
          "comes in,package,file,sha256\n",
          to);
    for (size_t i = 0; i < json_array_size(libraries); i++) {
        const json_t *one = json_array_get(libraries, i);
        const known *k = known_of(evidence_text(one, "soname"));
        put_csv(to, *k->name ? k->name : evidence_text(one, "soname"), ',');
        put_csv(to, evidence_text(one, "version"), ',');
        put_csv(to, k == &unknown ? supplier_of(k, one) : k->maker, ',');
        put_csv(to, k->purpose, ',');
        put_csv(to, licence_of(k, one), ',');
        put_csv(to, k->limits, ',');
        put_csv(to, k->anomalies, ',');
        fputs(",", to); /* empty field, in which the reviewer enters the date */
        put_csv(to,
                json_is_true(json_object_get(one, "linked")) ? "linked" : "loaded by another library or as a driver",
                ',');
        put_csv(to, evidence_text(one, "package"), ',');
        put_csv(to, evidence_text(one, "file"), ',');
        put_csv(to, evidence_text(one, "sha256"), '\n');
    }
    put_build(to, compiler_of(evidence_text(build, "compiler")), evidence_text(build, "compiler"), "",
              "compiles osteon", "a compiler may err; each build is compared with the reference and the tests");
    json_object_foreach(json_object_get(build, "headers"), name, version)
        put_build(to, headers_of(name), name, json_string_value(version) ? json_string_value(version) : "",
                  "headers at build time", "the version that runs is above");
    json_decref(libraries);
}

/* Makes a package URL: "libssl3 3.0.11-1" on Debian becomes "pkg:deb/debian/libssl3@3.0.11-1". Reserved characters
   are percent-encoded. */
static json_t *package_reference(const char *distribution, const char *package, const char *version)
{
    char url[256];
    size_t n = (size_t)snprintf(url, sizeof url, "pkg:deb/%.30s/%.80s@", *distribution ? distribution : "debian",
                                package);
    for (; *version && n + 4 < sizeof url; version++)
        if (*version == ':' || *version == '+' || *version == '%')
            n += (size_t)snprintf(url + n, sizeof url - n, "%%%02X", (unsigned)*version);
        else
            n += (size_t)snprintf(url + n, sizeof url - n, "%c", *version);
    return json_pack("[{s:s,s:s,s:s}]", "referenceCategory", "PACKAGE-MANAGER", "referenceType", "purl",
                     "referenceLocator", url);
}

static json_t *sbom_package(size_t number, const json_t *one, const char *distribution)
{
    const known *k = known_of(evidence_text(one, "soname"));
    char id[40], supplier[300];
    const char *version = evidence_text(one, "version"), *maker = supplier_of(k, one);
    snprintf(id, sizeof id, "SPDXRef-Library-%zu", number);
    if (strcmp(maker, "NOASSERTION") == 0)
        snprintf(supplier, sizeof supplier, "NOASSERTION");
    else
        snprintf(supplier, sizeof supplier, "Organization: %.280s", maker);
    for (char *c = supplier; *c; c++) /* SPDX has the address in brackets */
        *c = (char)(*c == '<' ? '(' : *c == '>' ? ')' : *c);
    json_t *o = json_pack("{s:s,s:s,s:s,s:s,s:s,s:b,s:s,s:s,s:s,s:s,s:[{s:s,s:s}]}", "SPDXID", id, "name",
                          evidence_text(one, "soname"), "packageFileName", evidence_text(one, "file"), "supplier",
                          supplier, "downloadLocation", "NOASSERTION", "filesAnalyzed", false, "licenseConcluded",
                          "NOASSERTION", "licenseDeclared", licence_of(k, one), "copyrightText", "NOASSERTION",
                          "primaryPackagePurpose", "LIBRARY", "checksums", "algorithm", "SHA256", "checksumValue",
                          evidence_text(one, "sha256"));
    if (*version)
        json_object_set_new(o, "versionInfo", json_string(version));
    if (*evidence_text(one, "package"))
        json_object_set_new(o, "externalRefs", package_reference(distribution, evidence_text(one, "package"), version));
    return o;
}

static void sbom(FILE *to, json_t *tools)
{
    const json_t *program = part_of(tools, "program"), *build = part_of(tools, "build");
    json_t *libraries = libraries_of(tools), *packages = json_array(), *relations = json_array();
    char space[200], creator[64], hex[OST_DIGEST_HEX], *text = json_dumps(tools, JSON_SORT_KEYS | JSON_COMPACT);
    ost_digest digest = {{0}};
    ost_error none = {0};
    bool proprietary = false;
    out_of_memory |= !text || ost_digest_bytes(text, strlen(text), &digest, &none) != OST_OK;
    free(text);
    snprintf(space, sizeof space, "https://spdx.org/spdxdocs/osteon-%.20s-%s", evidence_text(program, "version"),
             ost_digest_hex(&digest, hex));
    snprintf(creator, sizeof creator, "Tool: osteon-%.20s", evidence_text(program, "version"));
    json_array_append_new(packages,
                          json_pack("{s:s,s:s,s:s,s:s,s:s,s:b,s:s,s:s,s:s,s:s,s:[{s:s,s:s}],s:s}", "SPDXID",
                                    "SPDXRef-osteon", "supplier", "Organization: the osteon project", "name", "osteon",
                                    "versionInfo", evidence_text(program, "version"), "downloadLocation", "NOASSERTION",
                                    "filesAnalyzed", false, "licenseConcluded", "Apache-2.0", "licenseDeclared",
                                    "Apache-2.0", "copyrightText", "NOASSERTION", "primaryPackagePurpose",
                                    "APPLICATION", "checksums", "algorithm", "SHA256", "checksumValue",
                                    evidence_text(program, "sha256"), "sourceInfo", evidence_text(build, "commit")));
    json_array_append_new(relations, json_pack("{s:s,s:s,s:s}", "spdxElementId", "SPDXRef-DOCUMENT", "relationshipType",
                                               "DESCRIBES", "relatedSpdxElement", "SPDXRef-osteon"));
    for (size_t i = 0; i < json_array_size(libraries); i++) {
        const json_t *one = json_array_get(libraries, i);
        char id[40];
        snprintf(id, sizeof id, "SPDXRef-Library-%zu", i + 1);
        json_array_append_new(packages, sbom_package(i + 1, one, evidence_text(program, "distribution")));
        if (json_is_true(json_object_get(one, "linked")))
            json_array_append_new(relations, json_pack("{s:s,s:s,s:s}", "spdxElementId", "SPDXRef-osteon",
                                                       "relationshipType", "DYNAMIC_LINK", "relatedSpdxElement", id));
        else
            json_array_append_new(relations, json_pack("{s:s,s:s,s:s}", "spdxElementId", "SPDXRef-osteon",
                                                       "relationshipType", "DEPENDS_ON", "relatedSpdxElement", id));
        proprietary |= strcmp(known_of(evidence_text(one, "soname"))->licence, "LicenseRef-proprietary") == 0;
    }
    const char *date = evidence_text(build, "source_date");
    json_t *o = json_pack(
        "{s:s,s:s,s:s,s:s,s:s,s:{s:s,s:[s],s:s},s:O,s:O}", "spdxVersion", "SPDX-2.3", "dataLicense", "CC0-1.0",
        "SPDXID", "SPDXRef-DOCUMENT", "name", "osteon", "documentNamespace", space, "creationInfo", "created",
        *date ? date : "1970-01-01T00:00:00Z", "creators", creator, "comment",
        "created is the date of the program's source, so that equal programs on equal machines have equal documents",
        "packages", packages, "relationships", relations);
    if (proprietary)
        json_object_set_new(o, "hasExtractedLicensingInfos",
                            json_pack("[{s:s,s:s,s:s}]", "licenseId", "LicenseRef-proprietary", "name",
                                      "the maker's own licence", "extractedText", "See the driver's package."));
    json_dumpf(o, to, JSON_SORT_KEYS | JSON_INDENT(1));
    fputc('\n', to);
    json_decref(o);
    json_decref(relations);
    json_decref(packages);
    json_decref(libraries);
}

static ost_status write_one(const char *name, void (*make)(FILE *to, json_t *tools), json_t *tools, evidence_sink *sink,
                            void *user, ost_error *err)
{
    ost_memory_stream made;
    FILE *to = ost_memory_stream_open(&made);
    if (!to)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    out_of_memory = false;
    make(to, tools);
    const bool complete = ost_memory_stream_close(to, &made) && !out_of_memory;
    const ost_status status = complete ? sink(user, name, made.bytes, made.size, err)
                                       : ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", name);
    free(made.bytes);
    return status;
}

ost_status software_write(json_t *tools, evidence_sink *sink, void *user, ost_error *err)
{
    ost_status status = write_one(SBOM_FILE, sbom, tools, sink, user, err);
    return status == OST_OK ? write_one(SOUP_FILE, soup, tools, sink, user, err) : status;
}
