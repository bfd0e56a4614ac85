// What to run: a kind of job, and the fields of its request. Models and sets that are ticked are ticked for every kind.
export default {
  emits: ["estimate", "run"],
  props: { kinds: Array, given: Object, estimate: String, refusal: String, busy: Boolean },
  data() { return { kind: "run", values: JSON.parse(JSON.stringify(this.given)), timer: null }; },
  mounted() { this.changed(); document.addEventListener("keydown", this.pressed); },
  unmounted() { document.removeEventListener("keydown", this.pressed); },
  computed: {
    chosen() { return this.kinds.find((one) => one.kind === this.kind) || this.kinds[0]; },
    value() { return this.values[this.chosen.kind]; },
    short() { return this.chosen.fields.filter((field) => field.kind === "text" || field.kind === "choice"); },
    flags() { return this.chosen.fields.filter((field) => field.kind === "flag"); },
    many() { return this.chosen.fields.filter((field) => field.kind === "many"); },
    // Every answer of the server brings the fields anew: what counts is whether they say something else.
    offered() { return JSON.stringify(this.kinds); },
  },
  watch: {
    // A case that got a spring or a lift law may be run by other models.
    offered() {
      Object.entries(this.given).forEach(([kind, values]) => { this.values[kind] = { ...values, ...this.values[kind] }; });
      this.changed();
    },
  },
  methods: {
    wish() {
      const offered = (field, one) => field.choices.some((choice) => choice.value === one);
      const given = this.chosen.fields.map((field) => [field.name, field.kind === "many" ? this.value[field.name].filter((one) => offered(field, one)) : this.value[field.name]]);
      return { kind: this.chosen.kind, given: Object.fromEntries(given.filter(([, value]) => value !== "")) };
    },
    changed() { clearTimeout(this.timer); this.timer = setTimeout(() => this.$emit("estimate", this.wish()), 250); },
    tick(field) { Object.values(this.values).forEach((values) => { values[field.name] = this.value[field.name]; }); this.changed(); },
    refused(field) { return this.refusal?.toLowerCase().startsWith(field.name) ? "true" : null; },
    // A quantity that is chosen brings its ends.
    pick(field) {
      Object.assign(this.value, field.choices.find((one) => one.value === this.value[field.name])?.sets);
      this.changed();
    },
    // Ctrl+Enter runs from any field, whose value is taken first.
    pressed(event) {
      if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey) || this.busy) { return; }
      event.preventDefault();
      document.activeElement?.blur();
      setTimeout(() => this.run(), 50);
    },
    run() { this.$emit("run", this.wish()); },
  },
  template: `
<form class="panel order" aria-labelledby="order-title" @submit.prevent="run">
  <h2 id="order-title" class="off-screen">Run</h2>
  <fieldset><legend class="off-screen">What to run</legend><div class="row kinds">
    <label v-for="one in kinds" :key="one.kind" class="check" :for="'kind-' + one.kind"><input type="radio" :id="'kind-' + one.kind" name="kind" :value="one.kind" v-model="kind" @change="changed">{{ one.label }}</label>
  </div></fieldset>
  <div class="row end">
    <div v-for="field in short" :key="field.name" class="labelled" :class="field.usual && field.usual.length < 10 ? 'short' : ''" :title="field.help"><label :for="'order-' + field.name">{{ field.label }}</label>
      <select v-if="field.kind === 'choice'" :id="'order-' + field.name" v-model="value[field.name]" :aria-invalid="refused(field)" @change="pick(field)"><option v-for="one in field.choices" :key="one.value" :value="one.value">{{ one.label }}</option></select>
      <input v-else type="text" :id="'order-' + field.name" v-model="value[field.name]" @input="changed" autocomplete="off" :placeholder="field.usual" :aria-invalid="refused(field)" aria-describedby="order-refusal"></div>
    <button type="submit" class="button main" id="run-button" :disabled="busy" title="Ctrl+Enter from any field" aria-keyshortcuts="Control+Enter">{{ busy ? "Running" : "Run" }}</button>
  </div>
  <fieldset v-for="field in many" :key="field.name" :class="field.name"><legend>{{ field.label }}</legend><div class="row">
      <label v-for="one in field.choices" :key="one.value" class="check" :for="field.name + '-' + one.value" :title="one.hint"><input type="checkbox" :id="field.name + '-' + one.value" :value="one.value" v-model="value[field.name]" @change="tick(field)">{{ one.label }}</label>
  </div></fieldset>
  <div class="row"><label v-for="field in flags" :key="field.name" class="check" :title="field.help"><input type="checkbox" v-model="value[field.name]" @change="changed">{{ field.label }}</label></div>
  <p class="refusal" id="order-refusal" role="alert">{{ refusal }}</p>
  <p class="hint" role="status">{{ refusal ? "" : estimate }}</p>
</form>`,
};
