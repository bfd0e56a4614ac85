// What to run: kind, spring models, speeds and, of a study, quantity and range.
export default {
  emits: ["estimate", "run"],
  props: { models: Array, sets: Array, speeds: String, sweep: String, quantities: Array, outputs: Array, estimate: String, refusal: String, busy: Boolean },
  data() {
    return { kind: "run", at: this.speeds, over: this.sweep, chosen: Object.fromEntries(this.models.map((one) => [one.word, one.chosen])),
      chosenSets: Object.fromEntries(this.sets.map((one) => [one.word, one.chosen])), key: "", low: "", high: "", points: 9, output: (this.outputs[0] || {}).name || "", timer: null };
  },
  mounted() { this.changed(); document.addEventListener("keydown", this.pressed); },
  unmounted() { document.removeEventListener("keydown", this.pressed); },
  computed: {
    quantity() { return this.quantities.find((one) => one.key === this.key); },
    // Every answer of the server brings the list anew: what counts is whether it says something else.
    offered() { return JSON.stringify(this.quantities); },
  },
  watch: {
    offered() { this.changed(); },
    // A case that got a spring or a lift law may be run by other models.
    models() { this.models.forEach((one) => { if (!(one.word in this.chosen)) { this.chosen[one.word] = one.chosen; } }); },
  },
  methods: {
    wish() {
      return { kind: this.kind, speeds: this.kind === "sweep" ? this.over : this.at, models: this.models.map((one) => one.word).filter((word) => this.chosen[word]),
        sets: this.sets.length ? this.sets.map((one) => one.word).filter((word) => this.chosenSets[word]) : null, key: this.key, low: this.low, high: this.high, points: Number(this.points), output: this.output,
        label: this.quantity ? this.quantity.label.charAt(0).toLowerCase() + this.quantity.label.slice(1) : "" };
    },
    changed() { clearTimeout(this.timer); this.timer = setTimeout(() => this.$emit("estimate", this.wish()), 250); },
    pick() {
      // A fifth either way: over the whole range of a slider most points of a study may be no engine.
      if (this.quantity) {
        const { low, high, value } = this.quantity, ends = [0.8 * value, 1.2 * value].sort((one, other) => one - other);
        this.low = this.text(value ? Math.max(low, ends[0]) : low);
        this.high = this.text(value ? Math.min(high, ends[1]) : high);
      }
      this.changed();
    },
    text(value) { return Number(Number(value).toPrecision(4)) + (this.quantity.unit ? " " + this.quantity.unit : ""); },
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
    <label class="check" for="kind-run"><input type="radio" id="kind-run" name="kind" value="run" v-model="kind" @change="changed">Run at engine speeds</label>
    <label class="check" for="kind-sweep"><input type="radio" id="kind-sweep" name="kind" value="sweep" v-model="kind" @change="changed">Sweep over engine speed</label>
    <label class="check" for="kind-study"><input type="radio" id="kind-study" name="kind" value="study" v-model="kind" @change="changed">Study of a quantity</label>
  </div></fieldset>
  <div class="row end">
    <div class="labelled speeds" v-if="kind !== 'sweep'"><label for="order-speeds">Engine speeds (crank)</label>
      <input id="order-speeds" type="text" v-model="at" @input="changed" autocomplete="off" placeholder="4200, 5600 rpm" :aria-invalid="refusal ? 'true' : null" aria-describedby="order-refusal"></div>
    <div class="labelled speeds" v-else><label for="order-sweep">Engine speeds, first:last:step</label>
      <input id="order-sweep" type="text" v-model="over" @input="changed" autocomplete="off" placeholder="1000:9000:200 rpm" :aria-invalid="refusal ? 'true' : null" aria-describedby="order-refusal"></div>
    <template v-if="kind === 'study'">
      <div class="labelled"><label for="study-key">Quantity varied</label><select id="study-key" v-model="key" @change="pick"><option value="" disabled>choose …</option>
        <option v-for="one in quantities" :key="one.key" :value="one.key">{{ one.group }}: {{ one.label }}</option></select></div>
      <div class="labelled short"><label for="study-low">From</label><input id="study-low" type="text" v-model="low" @input="changed"></div>
      <div class="labelled short"><label for="study-high">To</label><input id="study-high" type="text" v-model="high" @input="changed"></div>
      <div class="labelled short"><label for="study-points">Points</label><input id="study-points" type="text" inputmode="numeric" v-model="points" @input="changed"></div>
      <div class="labelled"><label for="study-output">Result</label><select id="study-output" v-model="output" @change="changed"><option v-for="one in outputs" :key="one.name" :value="one.name">{{ one.label }}</option></select></div>
    </template>
    <button type="submit" class="button main" id="run-button" :disabled="busy" title="Ctrl+Enter from any field" aria-keyshortcuts="Control+Enter">{{ busy ? "Running" : { run: "Run", sweep: "Start the sweep", study: "Start the study" }[kind] }}</button>
  </div>
  <fieldset class="models"><legend>Spring models</legend><div class="row">
    <label v-for="one in models" :key="one.word" class="check" :for="'model-' + one.word" :title="one.hint"><input type="checkbox" :id="'model-' + one.word" v-model="chosen[one.word]" @change="changed">{{ one.label }}</label>
  </div></fieldset>
  <fieldset v-if="sets.length" class="sets"><legend>Spring sets</legend><div class="row">
    <label v-for="(one, place) in sets" :key="one.word" class="check" :for="'set-' + place"><input type="checkbox" :id="'set-' + place" v-model="chosenSets[one.word]" @change="changed">{{ one.word }}</label>
  </div></fieldset>
  <p class="refusal" id="order-refusal" role="alert">{{ refusal }}</p>
  <p class="hint" role="status">{{ refusal ? "" : estimate }}</p>
</form>`,
};
