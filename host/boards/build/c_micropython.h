// What the core's C (host/boards/build/c_source.py) needs of MicroPython.
// Hot functions that a role does not use, and names that only some of them need, are left to the compiler to drop.
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-variable"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#include <string.h>

#include "py/objarray.h"
#include "py/objtype.h"
#include "py/runtime.h"

typedef mp_obj_t core_obj;
#define CORE_NAME(name) MP_QSTR_##name
#define core_set(object, name, value) mp_store_attr(object, name, value)

// An attribute of an object. Looked for, it costs a hundred instructions; so each place that asks keeps where it lay.
#define core_get(object, name) ({ static uint16_t place; core_get_at(object, name, &place); })
static __attribute__((noinline)) core_obj core_find(core_obj object, qstr name, uint16_t *place) {
    if (mp_obj_is_instance_type(mp_obj_get_type(object))) {
        mp_map_t *own = &((mp_obj_instance_t *)MP_OBJ_TO_PTR(object))->members;
        mp_map_elem_t *found = mp_map_lookup(own, MP_OBJ_NEW_QSTR(name), MP_MAP_LOOKUP);
        if (found != NULL) {
            *place = found - own->table;
            return found->value;
        }
    }
    return mp_load_attr(object, name);
}
static core_obj core_get_at(core_obj object, qstr name, uint16_t *place) {
    mp_obj_instance_t *instance = MP_OBJ_TO_PTR(object);
    if (mp_obj_is_obj(object) && mp_obj_is_instance_type(instance->base.type) && *place < instance->members.alloc) {
        mp_map_elem_t *kept = &instance->members.table[*place];
        if (kept->key == MP_OBJ_NEW_QSTR(name)) {
            return kept->value;
        }
    }
    return core_find(object, name, place);
}

// The elements of an array or of bytes, or the address that a number is (a chip's registers).
static __attribute__((noinline)) void *core_address(core_obj object) {
    if (mp_obj_is_int(object)) {
        return (void *)(uintptr_t)mp_obj_get_int_truncated(object);
    }
    mp_buffer_info_t info;
    mp_get_buffer_raise(object, &info, MP_BUFFER_READ);
    return info.buf;
}
static void *core_block(core_obj object) {
    if (mp_obj_is_exact_type(object, &mp_type_array) || mp_obj_is_exact_type(object, &mp_type_bytearray)) {
        return ((mp_obj_array_t *)MP_OBJ_TO_PTR(object))->items;
    }
    return core_address(object);
}

static inline core_obj core_item(core_obj object, int32_t place) {
    return mp_obj_subscr(object, MP_OBJ_NEW_SMALL_INT(place), MP_OBJ_SENTINEL);
}

// bound(function, a, b): calls function(a, b, ...), without allocating; shared/runtime.py has it in Python.
typedef struct {
    mp_obj_base_t base;
    mp_obj_t function;
    size_t count;
    mp_obj_t given[10];
} core_bound_t;

static mp_obj_t core_bound_call(mp_obj_t self, size_t count, size_t named, const mp_obj_t *more) {
    core_bound_t *bound = MP_OBJ_TO_PTR(self);
    mp_obj_t all[12];
    if (named || bound->count + count > MP_ARRAY_SIZE(all)) {
        mp_raise_TypeError(NULL);
    }
    memcpy(all, bound->given, bound->count * sizeof(mp_obj_t));
    memcpy(all + bound->count, more, count * sizeof(mp_obj_t));
    return mp_call_function_n_kw(bound->function, bound->count + count, 0, all);
}

static MP_DEFINE_CONST_OBJ_TYPE(core_type_bound, MP_QSTR_bound, MP_TYPE_FLAG_NONE, call, core_bound_call);

static mp_obj_t core_bound(size_t count, const mp_obj_t *given) {
    core_bound_t *bound = mp_obj_malloc(core_bound_t, &core_type_bound);
    bound->function = given[0];
    bound->count = count - 1;
    memcpy(bound->given, given + 1, bound->count * sizeof(mp_obj_t));
    return MP_OBJ_FROM_PTR(bound);
}
static MP_DEFINE_CONST_FUN_OBJ_VAR_BETWEEN(core_bound_obj, 1, 11, core_bound);

#define CORE_NUMBER(object) ((int32_t)mp_obj_get_int_truncated(object))
#define CORE_RESULT(call) mp_obj_new_int(call)
#define CORE_SILENT(call) ((call), mp_const_none)
#define CORE_EXPOSE_0(name, answer) \
    static mp_obj_t py_##name(void) { return answer(name()); } \
    static MP_DEFINE_CONST_FUN_OBJ_0(obj_##name, py_##name);
#define CORE_EXPOSE_N(name, answer, count, ...) \
    static mp_obj_t py_##name(size_t given, const mp_obj_t *a) { (void)given; return answer(name(__VA_ARGS__)); } \
    static MP_DEFINE_CONST_FUN_OBJ_VAR_BETWEEN(obj_##name, count, count, py_##name);
#define CORE_ENTRY(name) { MP_ROM_QSTR(MP_QSTR_##name), MP_ROM_PTR(&obj_##name) },
#define CORE_MODULE(entries) \
    static const mp_rom_map_elem_t core_table[] = { { MP_ROM_QSTR(MP_QSTR___name__), MP_ROM_QSTR(MP_QSTR__core) }, \
        { MP_ROM_QSTR(MP_QSTR_bound), MP_ROM_PTR(&core_bound_obj) }, entries }; \
    static MP_DEFINE_CONST_DICT(core_globals, core_table); \
    const mp_obj_module_t core_module = { .base = { &mp_type_module }, .globals = (mp_obj_dict_t *)&core_globals }; \
    MP_REGISTER_MODULE(MP_QSTR__core, core_module);
