/* physics_row: see physics_row.h */
#include "physics/physics_row.h"

PDI_FN pdi_physics_row *pdi_physics_row_add(pdi_physics_list *list, const char *name, pd_part part,
                                            int (*is_present)(const pd_setup *setup))
{
    pdi_physics_row *row = &list->row[list->count++];
    row->name = name;
    row->part = part;
    row->is_present = is_present;
    return row;
}

PDI_FN void pdi_physics_row_add_fields(pdi_physics_row *row, pd_field first, pd_field last,
                                       double (*sample)(const pd_model *m, pd_field field, int32_t node),
                                       const double *(*get_values)(const pd_model *m, pd_field field, int component))
{
    pdi_physics_sampler *sampler = &row->sampler[row->samplers++];
    sampler->first = first;
    sampler->last = last;
    sampler->sample = sample;
    sampler->get_values = get_values;
}

PDI_FN int pdi_physics_row_always(const pd_setup *setup)
{
    (void)setup;
    return 1;
}
