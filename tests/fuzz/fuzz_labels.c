/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Imports a small CT with arbitrary bytes as its label map and as a file of names. The result must
 * be an error of one line, or a bone with no more voxels than the CT.
 */
#include "fuzz.h"

#include <osteon/io.h>

const char *const fuzz_words[] = {"NRRD0005\n",
                                  "sizes: ",
                                  "space origin: ",
                                  "Segment0_Name:=",
                                  "Segment1_LabelValue:=",
                                  "Segment99999_Name:=",
                                  "scapula",
                                  "<Label Key=\"3\">",
                                  "<![CDATA[",
                                  "]]></Label>",
                                  "{\"3\": ",
                                  "\"scapula\"",
                                  "3 scapula\n",
                                  "3,scapula\n",
                                  "32768",
                                  "4294967297",
                                  "\"",
                                  NULL};

#define GRID "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n"
static const char *const seeds[] = {
    "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n" GRID "encoding: text\nSegment0_Name:=scapula\n"
    "Segment0_LabelValue:=3\n\n3 3 0 3 1 0 3 3\n",
    "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 1 2 1\n" GRID "encoding: text\nSegment1_LabelValue:=3\n"
    "Segment1_Name:=SCAPULA\nSegment0_Name:=\\n\\\\\n\n3 1\n",
    "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 2 2 2 2\n" GRID "encoding: text\nSegment0_Name:=scapula\n\n3\n",
    "3 scapula\n", "label,name\r\n3,scapula\r\n", "# ITK\n 3 255 0 0 1 1 1 \"scapula\"\n", "{\"3\": \"scapula\"}",
    "{\"scapula\": 3, \"rib\": -1}"};

enum { NIFTI_SEED = sizeof seeds / sizeof seeds[0], NIFTI_BYTES = 352 + 80 + 8 };

static void put(uint8_t *at, uint32_t bits, size_t size)
{
    for (size_t i = 0; i < size; i++)
        at[i] = (uint8_t)(bits >> 8 * i);
}

/* Makes a NIfTI label map of 2 x 2 x 2 uint8 voxels with a table of labels in an extension. */
static size_t nifti_seed(uint8_t *bytes, size_t capacity)
{
    static const char table[] = "<LabelTable><Label Key=\"3\"><![CDATA[scapula]]></Label></LabelTable>";
    if (capacity < NIFTI_BYTES)
        return 0;
    memset(bytes, 0, NIFTI_BYTES);
    put(bytes, 348, 4);
    for (size_t a = 0; a < 4; a++) {
        put(bytes + 40 + 2 * a, a ? 2 : 3, 2);
        put(bytes + 76 + 4 * a, 0x3f800000, 4); /* spacing of 1 mm */
    }
    put(bytes + 70, 2, 2);
    put(bytes + 72, 8, 2);
    put(bytes + 108, 0x43d80000, 4); /* the offset of the voxels, 432, as a float */
    bytes[123] = 2;                  /* mm */
    memcpy(bytes + 344, "n+1", 4);
    bytes[348] = 1;
    put(bytes + 352, 80, 4);
    memcpy(bytes + 360, table, sizeof table - 1);
    memset(bytes + 432, 3, 8);
    return NIFTI_BYTES;
}

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (index == NIFTI_SEED)
        return nifti_seed(bytes, capacity);
    if (index > NIFTI_SEED)
        return 0;
    const size_t size = strlen(seeds[index]) < capacity ? strlen(seeds[index]) : capacity;
    memcpy(bytes, seeds[index], size);
    return size;
}

static ost_backend *backend;
static char ct_path[1024];

static void make_ct(void)
{
    static const char ct[] = "NRRD0005\ntype: int16\ndimension: 3\nsizes: 2 2 2\n" GRID "encoding: text\n\n"
                             "500 500 500 500 500 500 500 500\n";
    ost_error err = {0};
    fuzz_require(ost_backend_open("ref", &backend, &err) == OST_OK);
    snprintf(ct_path, sizeof ct_path, "%s", fuzz_file("ct.nrrd", (const uint8_t *)ct, sizeof ct - 1));
}

static void import(const char *mask, const char *names, const char *word)
{
    const ost_import_options options = {
        .mask = mask, .mask_names = {word}, .mask_name_count = word ? 1 : 0, .mask_names_file = names};
    ost_error err = {0};
    ost_bone *bone;
    ost_bone_info info;
    ost_import_result result;
    const ost_status status = ost_import(backend, ct_path, &options, &bone, &result, &err);
    if (status != OST_ERR_UNAVAILABLE)
        fuzz_require_error(status, err, fuzz_folder());
    if (status != OST_OK)
        return;
    fuzz_require(ost_bone_info_get(bone, &info, &err) == OST_OK);
    fuzz_require(info.active_voxels <= 8 && (uint64_t)info.active_voxels == 8 - result.mask.removed);
    ost_bone_free(bone);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char labels[] = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n" GRID "encoding: text\n\n"
                                 "3 3 3 3 1 1 1 1\n";
    char mask[1024], names[1024];
    if (!backend)
        make_ct();
    snprintf(mask, sizeof mask, "%s", fuzz_file("mask", data, size));
    ost_geometry g;
    ost_error err = {0};
    if (ost_volume_read_header(mask, &g, NULL, NULL, &err) != OST_OK || ost_dims_count(g.dims) <= 1 << 22) {
        import(mask, NULL, NULL);
        import(mask, NULL, "scapula");
    }
    snprintf(names, sizeof names, "%s", fuzz_file("names", data, size));
    snprintf(mask, sizeof mask, "%s", fuzz_file("labels.nrrd", (const uint8_t *)labels, sizeof labels - 1));
    import(mask, names, "scapula");
    return 0;
}
